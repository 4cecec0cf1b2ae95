#pragma once

// A pose graph that grows, kept solved: what a new pose or edge costs goes with what it changes,
// not with the size of the graph.
//
// Fluid relinearisation and partial back-substitution as in Kaess, Johannsson, Roberts, Ila,
// Leonard, Dellaert 2012 ("iSAM2", sections 3 and 4); ordering by blocks as in Polok, Ila, Solony,
// Smrz, Zemcik 2013 ("Incremental block Cholesky factorization for nonlinear least squares in
// robotics").

#include <cstddef>
#include <vector>

#include <wayfare/graph/incremental_cholesky.hpp>
#include <wayfare/graph/incremental_sum.hpp>
#include <wayfare/graph/pose_graph.hpp>
#include <wayfare/graph/report.hpp>

namespace wayfare {

struct IncrementalOptions {
  /// Largest component of a pose's step (m or rad) up to which its edges stay linearised where they
  /// are. Smaller: nearer to the optimum, more columns factorised again. 0: every pose that moved.
  double relinearise_step = 0.05;
  /// A step that changes by no more than this (m or rad) is not taken further down the tree. 0: all
  /// changes are.
  double solve_change = 1e-3;
  /// Linear systems solved at most; a further one follows while some pose is past relinearise_step.
  int max_rounds = 2;
  /// Once this many times the work of one whole factorisation has been spent on parts, all is
  /// linearised and ordered anew. Larger: rarer. Counted, not timed: the same on every machine.
  double reorder_work = 20.0;
};

/// What one update did.
struct IncrementalReport {
  double cost = 0.0;       ///< Σ ρ(eᵀΩe) at the poses after it
  int relinearised = 0;    ///< poses whose edges were linearised again
  int refactored = 0;      ///< block columns factorised again, summed over the rounds
  int substituted = 0;     ///< block columns whose step was computed, likewise
  double flops = 0.0;      ///< multiplications and additions of the factorisation
  int rounds = 0;          ///< linear systems solved
  bool reordered = false;  ///< all was linearised and ordered anew
  bool fell_back = false;  ///< the step raised the cost; the batch optimiser took over
};

/// Gauss-Newton on a graph that grows. With both thresholds zero, every round is a whole
/// Gauss-Newton step of the batch optimiser, to rounding; with others the cost stays near its
/// optimum (tests/graph/incremental_replay_test.cpp has by how much). Same calls, same bytes.
template <LieGroup G>
class IncrementalOptimiser {
 public:
  /// `kernel` applies to edges marked `robust`.
  explicit IncrementalOptimiser(const RobustKernel& kernel = {}) : kernel_(kernel) {}

  /// Takes effect with the next update. `held`: it stays where it is; where none is held by the
  /// first update, pose 0 is. Returns its index; an Error where it is not finite.
  Result<int> add_pose(const G& initial, bool held = false);
  /// Likewise. An Error, and nothing taken, for what validate_edge refuses (a pose that was not
  /// added, a measurement that is not finite, an information that is not positive semi-definite …)
  /// and for an error too large to square.
  Result<void> add_edge(const PoseEdge<G>& edge);
  /// Adds the poses and edges by which `grown` is ahead of graph(); what they have in common is
  /// taken to be the same. An Error, and nothing taken, where one of them is refused, or where a
  /// pose is held now that was free.
  Result<void> append(const PoseGraph<G>& grown);
  /// Forgets the poses and edges added since the last update that succeeded.
  void discard_pending();

  /// Takes in what was added. Where it fails (a new pose is not connected to the others, or not
  /// determined by its edges: named) nothing solved has changed, and what was added still waits
  /// for what is missing.
  Result<IncrementalReport> update(const IncrementalOptions& options = {});

  /// The optimum as the batch optimiser finds it from the present poses, and everything linearised
  /// there; the kernel of `options` gives way to this one's. Where it fails nothing has changed.
  Result<OptimiseReport> optimise_fully(OptimiseOptions options = {});

  /// What the last update or optimise_fully that failed with ErrorCode::degenerate left open, as far
  /// as it was the edges that left it so.
  [[nodiscard]] const UndeterminedPose<G>& undetermined() const { return undetermined_; }

  /// The poses as solved; those added since, where they were put.
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
  [[nodiscard]] double cost_of(const PoseEdge<G>& edge) const;
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
  PoseGraph<G> graph_;  // all that was added; poses as estimated
  std::size_t solved_poses_ = 0, solved_edges_ = 0;
  IncrementalCholesky<kDof> system_;  // term k is edge k
  std::vector<G> origins_;            // where each admitted pose's edges are linearised
  std::vector<int> variable_of_;      // of each admitted pose, −1 where it is held
  std::vector<int> pose_of_;          // of each variable
  IncrementalSum costs_;              // of the edges
  std::vector<int> far_;              // poses whose step is past far_step_
  std::vector<char> is_far_;
  double far_step_ = 0.0;
  std::vector<int> edge_mark_;
  int stamp_ = 0;
  std::vector<Relinearised> relinearised_;
  std::vector<Moved> moved_;  // in this update
  double work_since_order_ = 0.0;
  UndeterminedPose<G> undetermined_;
};

// Compiled once in wayfare::slam.
extern template class IncrementalOptimiser<SE2d>;
extern template class IncrementalOptimiser<SE3d>;

}  // namespace wayfare
