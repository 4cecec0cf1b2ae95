#pragma once

// Incremental optimisation of a growing graph: the cost of a new variable or edge depends on what
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
#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include <wayfare/graph/detail/incremental_cholesky.hpp>
#include <wayfare/graph/detail/incremental_sum.hpp>
#include <wayfare/graph/optimise.hpp>
#include <wayfare/graph/pose_graph.hpp>
#include <wayfare/graph/report.hpp>

namespace wayfare {

/// When an update relinearises, substitutes and reorders.
struct IncrementalOptions {
  /// A variable's edges are relinearised if a component of its step (m or rad) exceeds this.
  /// Smaller: closer to the optimum, more columns refactorised. 0: every variable that moved.
  double relinearise_step = 0.05;
  /// Back-substitution continues down the tree where a step changes by more than this (m or rad).
  /// 0: with every change.
  double solve_change = 1e-3;
  /// If positive, instead of solve_change: where a step changes by more than this many standard
  /// deviations of the variable given its neighbours, √(Δᵀ H_vv Δ), times √(cost / edges), at most
  /// 1 (a posteriori standard deviations). It does not depend on the variable's units, and bounds
  /// what a change that is held back adds to the cost.
  double solve_deviations = 0.0;
  /// Maximum number of linear systems solved; a further one follows while a step exceeds
  /// relinearise_step.
  int max_rounds = 2;
  /// Everything is relinearised and reordered once partial factorisations have cost this many
  /// complete ones. Larger: rarer. In operations, not time: the same on every machine.
  double reorder_work = 20.0;
};

/// Steps of a pose graph are compared in m and rad. Variables of a factor graph have any units, and
/// a heading moves what is seen far away: its changes are compared with the information.
template <class Graph>
inline constexpr IncrementalOptions kIncrementalDefaults{.relinearise_step = 0.1,
                                                         .solve_deviations = 0.4};
/// Of a pose graph.
template <LieGroup G>
inline constexpr IncrementalOptions kIncrementalDefaults<PoseGraph<G>>{};

/// Statistics of one update.
struct IncrementalReport {
  double cost = 0.0;       ///< Σ ρ(eᵀΩe) at the values after it
  int relinearised = 0;    ///< variables whose edges were relinearised
  int refactored = 0;      ///< block columns refactorised, summed over the rounds
  int substituted = 0;     ///< block columns whose step was computed, summed over the rounds
  double flops = 0.0;      ///< multiplications and additions of the factorisation
  int rounds = 0;          ///< linear systems solved
  bool reordered = false;  ///< everything was relinearised and reordered
  bool fell_back = false;  ///< the step raised the cost; the batch optimiser took over
};

/// The graph of an incremental optimiser, whose last variables and edges may be pending: how they
/// are added. Specialised for pose graphs here, for factor graphs in growing_factor_graph.hpp.
template <class Graph>
class GrowingGraph;

/// Compiled in wayfare::graph for SE2d and SE3d.
template <LieGroup G>
class GrowingGraph<PoseGraph<G>> {
 public:
  /// `kernel` applies to edges marked `robust`.
  explicit GrowingGraph(const RobustKernel& kernel = {}) : kernel_(kernel) {}

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

  /// The solved poses; pending ones at their initial values.
  [[nodiscard]] const std::vector<G>& poses() const { return graph_.poses; }
  /// Solved and pending poses and edges.
  [[nodiscard]] const PoseGraph<G>& graph() const { return graph_; }

 protected:
  static constexpr int kBlock = ManifoldTraits<G>::kDof;  ///< numbers of a step of one pose
  using Value = G;                                        ///< a pose

  /// What is not pending.
  struct Solved {
    std::size_t poses = 0,  ///< number
        edges = 0,          ///< number
        fixed = 0;          ///< number
  };

  /// For containers.
  static std::size_t index(int i) { return static_cast<std::size_t>(i); }
  /// Numbers of what is solved.
  [[nodiscard]] Solved solved() const {
    return {solved_poses_, solved_edges_, graph_.fixed.size()};
  }
  /// Nothing is pending any more.
  void settle();
  /// What came after `before` is pending again.
  void unsettle(const Solved& before);
  /// Whether the pose is fixed.
  [[nodiscard]] bool is_held(int pose) const;
  /// Error: nothing to solve, or a pending pose that no edge reaches.
  [[nodiscard]] Result<void> check_pending() const;

  /// Of edges marked `robust`.
  [[nodiscard]] const RobustKernel& kernel() const { return kernel_; }
  /// Of a pose.
  [[nodiscard]] const G& value(int pose) const { return graph_.poses[index(pose)]; }
  /// Of a pose of `graph`.
  static void set_value(PoseGraph<G>& graph, int pose, const G& x) { graph.poses[index(pose)] = x; }
  /// The pose becomes origin ⊞ step.
  void place(int pose, const G& origin, const TangentOf<G>& step) {
    graph_.poses[index(pose)] = ManifoldTraits<G>::plus(origin, step);
  }

  // Edge k is term k.
  /// Number of edges.
  [[nodiscard]] std::size_t edges() const { return graph_.edges.size(); }
  /// The number of a term's edge.
  [[nodiscard]] static std::size_t edge_of(int term) { return index(term); }
  /// ρ(eᵀΩe) of edge k at the current poses.
  [[nodiscard]] double cost_of(std::size_t k) const {
    return robust_cost(graph_, graph_.edges[k], kernel_);
  }
  /// visit(term, its poses, its values), linearised at `origins`. Returns whether values are
  /// finite, which those of poses are, or the factorisation fails.
  template <class Visit>
  [[nodiscard]] bool linearise(std::size_t k, const std::vector<G>& origins,
                               const Visit& visit) const {
    const PoseEdge<G>& edge = graph_.edges[k];
    visit(static_cast<int>(k), edge.from, edge.to, terms_of(edge, origins));
    return true;
  }
  /// Names the edge for which `linearise` returned false.
  [[nodiscard]] Error fault_at(const std::vector<G>&) const { return cost_overflow(graph_); }

  PoseGraph<G> graph_;  ///< including pending; poses as estimated

 private:
  [[nodiscard]] IncrementalTerm<kBlock> terms_of(const PoseEdge<G>& edge,
                                                 const std::vector<G>& origins) const;

  RobustKernel kernel_;
  std::size_t solved_poses_ = 0, solved_edges_ = 0;
};

/// Gauss-Newton on a growing graph. With both thresholds zero, every round is a complete
/// Gauss-Newton step of the batch optimiser, to rounding; otherwise the cost stays near its optimum
/// (tests/graph/incremental_replay_test.cpp has the bounds). Deterministic. Variables and edges are
/// added by the members of GrowingGraph<Graph>:
///
///   IncrementalGraphOptimiser<FactorGraph<Variables<SE2d, Eigen::Vector2d>,
///                                         Edges<Between<SE2d>, BearingRange>>> growing;
///   const auto start = growing.add(SE2d(), true);         // fixed
///   const auto tree = growing.add(Eigen::Vector2d(5, 1)); // Result<VariableId<Eigen::Vector2d>>
///   growing.add(BearingRange{…}, *start, *tree);          // Result<void>
///   growing.update();
///   growing[*tree];
///
/// Compiled in wayfare::graph for pose graphs.
template <class Graph>
class IncrementalGraphOptimiser : public GrowingGraph<Graph> {
  using Growing = GrowingGraph<Graph>;

 public:
  using GrowingGraph<Graph>::GrowingGraph;
  /// Adds the pending variables and edges to the solution. On an Error (names a new pose that is
  /// not connected to the others, a variable not determined by its edges, or an edge whose error or
  /// Jacobian is not finite on the way) the solution is unchanged and they stay pending.
  Result<IncrementalReport> update(const IncrementalOptions& options = kIncrementalDefaults<Graph>);

  /// The batch optimiser from the current values, then relinearises everything there. Uses this
  /// object's kernel instead of that of `options`. On an Error nothing has changed.
  Result<OptimiseReport> optimise_fully(OptimiseOptions options = {});

  /// The undetermined variable and direction of the last update or optimise_fully that failed with
  /// ErrorCode::degenerate, if the edges were the cause.
  [[nodiscard]] const Undetermined<Graph::kBlock>& undetermined() const { return undetermined_; }

 private:
  static constexpr int kBlock = Graph::kBlock;
  using Step = Eigen::Matrix<double, kBlock, 1>;
  using Value = typename Growing::Value;

  struct Moved {
    int variable;
    Value before;
  };
  struct Relinearised {
    int variable;
    Value before;
    Step step;
  };

  using Growing::graph_;
  using Growing::index;

  Error fault_of(const FactorOutcome& outcome);
  void admit();
  void settle();
  void withdraw();
  Error restore(const typename Growing::Solved& before);

  void each_edge_of(const auto& changed, const auto& with);
  void relinearise_far(double threshold);
  void relinearise_all();
  void relinearise(int variable);
  void linearise_again();
  void undo_relinearisation();
  FactorOutcome refactor(IncrementalReport& report);
  void move_values(const IncrementalOptions& options, IncrementalReport& report);
  void find_costs();
  void find_deviation(bool may_decrease);
  Result<void> first_round(const IncrementalOptions& options, IncrementalReport& report);
  void further_rounds(const IncrementalOptions& options, IncrementalReport& report);
  void fall_back(IncrementalReport& report);
  Result<void> take_values(const typename Graph::Values& values, IncrementalReport& report);

  std::size_t admitted_variables_ = 0, admitted_edges_ = 0;  // in the last factorisation
  IncrementalCholesky<kBlock> system_;
  std::vector<Value> origins_;    // linearisation point of each admitted variable
  std::vector<int> column_of_;    // of each admitted variable, −1 if it is held
  std::vector<int> variable_of_;  // of each column
  IncrementalSum costs_;          // of the edges
  std::vector<int> far_;          // variables whose step exceeds far_step_
  std::vector<char> is_far_;
  double far_step_ = 0.0;
  bool finite_ = true;  // all that was linearised for the next factorisation
  std::vector<int> edge_mark_;
  int stamp_ = 0;
  std::vector<Relinearised> relinearised_;
  std::vector<Moved> moved_;  // in this update
  double work_since_order_ = 0.0;
  double deviation_ = 0.0;
  Undetermined<kBlock> undetermined_;
};

/// For pose graphs.
template <LieGroup G>
using IncrementalOptimiser = IncrementalGraphOptimiser<PoseGraph<G>>;

/// An edge of a replayed graph.
template <LieGroup G>
struct ReplayStep {
  PoseEdge<G> edge;  ///< added in this step
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

#include <wayfare/graph/detail/incremental_update.hpp>
