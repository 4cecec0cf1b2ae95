#pragma once

// Incremental optimisation of a growing pose graph: the cost of a new pose or edge depends on what
// it changes, not on the size of the graph.
//
// Fluid relinearisation and partial back-substitution as in Kaess, Johannsson, Roberts, Ila,
// Leonard, Dellaert 2012 ("iSAM2", sections 3 and 4); ordering by blocks as in Polok, Ila, Solony,
// Smrz, Zemcik 2013 ("Incremental block Cholesky factorization for nonlinear least squares in
// robotics").
//
// Replays a complete graph incrementally: edge by edge, each pose with the first edge that reaches
// it.

#include <algorithm>
#include <cstddef>
#include <cstdlib>
#include <utility>
#include <vector>

#include <wayfare/graph/detail/incremental_cholesky.hpp>
#include <wayfare/graph/detail/incremental_sum.hpp>
#include <wayfare/graph/pose_graph.hpp>
#include <wayfare/graph/report.hpp>

namespace wayfare {

struct IncrementalOptions {
  /// A pose's edges are relinearised if a component of its step (m or rad) exceeds this. Smaller:
  /// closer to the optimum, more columns refactorised. 0: every pose that moved.
  double relinearise_step = 0.05;
  /// Back-substitution continues down the tree where a step changes by more than this (m or rad).
  /// 0: with every change.
  double solve_change = 1e-3;
  /// Maximum number of linear systems solved; a further one follows while a step exceeds
  /// relinearise_step.
  int max_rounds = 2;
  /// Everything is relinearised and reordered once partial factorisations have cost this many
  /// complete ones. Larger: rarer. In operations, not time: the same on every machine.
  double reorder_work = 20.0;
};

/// Statistics of one update.
struct IncrementalReport {
  double cost = 0.0;       ///< Σ ρ(eᵀΩe) at the poses after it
  int relinearised = 0;    ///< poses whose edges were relinearised
  int refactored = 0;      ///< block columns refactorised, summed over the rounds
  int substituted = 0;     ///< block columns whose step was computed, summed over the rounds
  double flops = 0.0;      ///< multiplications and additions of the factorisation
  int rounds = 0;          ///< linear systems solved
  bool reordered = false;  ///< everything was relinearised and reordered
  bool fell_back = false;  ///< the step raised the cost; the batch optimiser took over
};

/// Gauss-Newton on a growing graph. With both thresholds zero, every round is a complete
/// Gauss-Newton step of the batch optimiser, to rounding; otherwise the cost stays near its optimum
/// (tests/graph/incremental_replay_test.cpp has the bounds). Deterministic. Compiled in
/// wayfare::graph for SE2d and SE3d.
template <LieGroup G>
class IncrementalOptimiser {
 public:
  /// `kernel` applies to edges marked `robust`.
  explicit IncrementalOptimiser(const RobustKernel& kernel = {}) : kernel_(kernel) {}

  /// Added with the next update. `held`: fixed; if none is fixed at the first update, pose 0 is.
  /// Returns its index; an Error if it is not finite.
  Result<int> add_pose(const G& initial, bool held = false);
  /// Added with the next update. Errors, with nothing added: those of validate_edge (an unknown
  /// pose, a measurement that is not finite, an information that is not positive semi-definite …)
  /// and an error too large to square.
  Result<void> add_edge(const PoseEdge<G>& edge);
  /// Adds the poses and edges of `grown` that graph() does not have; the common ones are assumed to
  /// be identical, except that pending ones may be fixed now. Errors, with nothing added: those of
  /// add_pose and add_edge, or a solved pose that was free and is fixed now.
  Result<void> append(const PoseGraph<G>& grown);
  /// Removes the poses, with their labels, and edges added since the last successful update.
  void discard_pending();

  /// Adds the pending poses and edges to the solution. On an Error (names a new pose that is not
  /// connected to the others or not determined by its edges) the solution is unchanged and they
  /// stay pending.
  Result<IncrementalReport> update(const IncrementalOptions& options = {});

  /// The batch optimiser from the current poses, then relinearises everything there. Uses this
  /// object's kernel instead of that of `options`. On an Error nothing has changed.
  Result<OptimiseReport> optimise_fully(OptimiseOptions options = {});

  /// The undetermined pose and direction of the last update or optimise_fully that failed with
  /// ErrorCode::degenerate, if the edges were the cause.
  [[nodiscard]] const Undetermined<ManifoldTraits<G>::kDof>& undetermined() const {
    return undetermined_;
  }

  /// The solved poses; pending ones at their initial values.
  [[nodiscard]] const std::vector<G>& poses() const { return graph_.poses; }
  [[nodiscard]] const PoseGraph<G>& graph() const { return graph_; }

 private:
  static constexpr int kDof = ManifoldTraits<G>::kDof;

  struct Moved {
    int pose;
    G before;
  };
  struct Relinearised {
    int pose;
    G before;
    TangentOf<G> step;
  };

  static std::size_t index(int i) { return static_cast<std::size_t>(i); }
  [[nodiscard]] bool is_held(int pose) const;
  [[nodiscard]] Result<void> check_pending() const;
  Error name_undetermined(const FactorOutcome& outcome);
  void admit();
  void settle();
  void withdraw();

  [[nodiscard]] IncrementalTerm<kDof> linearise(const PoseEdge<G>& edge) const;
  void relinearise_far(double threshold);
  void relinearise_all();
  void relinearise(int pose);
  void linearise_again();
  void undo_relinearisation();
  FactorOutcome refactor(IncrementalReport& report);
  void move_poses(const IncrementalOptions& options, IncrementalReport& report);
  void sum_costs(std::size_t first_moved);
  Result<void> first_round(const IncrementalOptions& options, IncrementalReport& report);
  void further_rounds(const IncrementalOptions& options, IncrementalReport& report);
  void fall_back(IncrementalReport& report);
  Result<void> take_poses(const std::vector<G>& poses, IncrementalReport& report);

  RobustKernel kernel_;
  PoseGraph<G> graph_;  // including pending; poses as estimated
  std::size_t solved_poses_ = 0, solved_edges_ = 0;
  IncrementalCholesky<kDof> system_;  // term k is edge k
  std::vector<G> origins_;            // linearisation point of each admitted pose
  std::vector<int> variable_of_;      // of each admitted pose, −1 if it is held
  std::vector<int> pose_of_;          // of each variable
  IncrementalSum costs_;              // of the edges
  std::vector<int> far_;              // poses whose step exceeds far_step_
  std::vector<char> is_far_;
  double far_step_ = 0.0;
  std::vector<int> edge_mark_;
  int stamp_ = 0;
  std::vector<Relinearised> relinearised_;
  std::vector<Moved> moved_;  // in this update
  double work_since_order_ = 0.0;
  Undetermined<ManifoldTraits<G>::kDof> undetermined_;
};

template <LieGroup G>
struct ReplayStep {
  PoseEdge<G> edge;
  /// The pose that the edge adds, −1 if both exist.
  int new_pose = -1;

  /// Initial value of the new pose from the edge.
  [[nodiscard]] G placed(const std::vector<G>& poses) const {
    if (new_pose == edge.to) return poses[static_cast<std::size_t>(edge.from)] * edge.measurement;
    return poses[static_cast<std::size_t>(edge.to)] * edge.measurement.inverse();
  }
};

/// The edges of a graph with poses in temporal order, sorted by their later pose, then by the
/// distance of the indices. Pose 0 exists from the start.
template <LieGroup G>
[[nodiscard]] std::vector<ReplayStep<G>> replay_steps(const PoseGraph<G>& graph) {
  std::vector<ReplayStep<G>> steps;
  for (const auto& edge : graph.edges) steps.push_back({edge});
  const auto key = [](const ReplayStep<G>& step) {
    return std::pair(std::max(step.edge.from, step.edge.to),
                     std::abs(step.edge.from - step.edge.to));
  };
  std::stable_sort(steps.begin(), steps.end(),
                   [&](const auto& a, const auto& b) { return key(a) < key(b); });
  int known = 1;
  for (auto& step : steps)
    if (key(step).first == known) step.new_pose = known++;
  return steps;
}

}  // namespace wayfare
