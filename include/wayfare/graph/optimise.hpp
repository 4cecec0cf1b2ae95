#pragma once

// x* = argmin Σ ρ(eᵀΩe) on a graph, and the covariance of x*.

#include <vector>

#include <wayfare/graph/detail/descent.hpp>
#include <wayfare/graph/detail/validate.hpp>
#include <wayfare/graph/linear_solver.hpp>

namespace wayfare {

/// Of graphs with blocks of N.
template <int N>
using DefaultSolver = MultifrontalCholesky<N>;

/// Optimises graphs by a solver of the library or of one's own. Reuses pattern, symbolic
/// factorisation and memory between calls while the structure is unchanged.
template <class Graph, LinearSolver Solver = DefaultSolver<Graph::kBlock>>
class GraphOptimiser {
  static_assert(Solver::kBlock == Graph::kBlock,
                "wayfare: the blocks of the solver, kBlock, are as large as those of the graph");

 public:
  static constexpr int kBlock = Graph::kBlock;  ///< numbers of a step of one variable
  /// Of a variable; the first dof rows and columns of a smaller one.
  using Covariance = Eigen::Matrix<double, kBlock, kBlock>;

  /// Moves the free variables of `graph` to a local minimum near their initial values. Errors, with
  /// the variables unchanged: those of validate, errors too large to square, a variable that the
  /// edges leave undetermined at the minimum (reported by `undetermined`), a solver whose solutions
  /// are not finite.
  Result<OptimiseReport> optimise(Graph& graph, const OptimiseOptions& options = {});

  /// The undetermined variable and direction of the last call that failed with
  /// ErrorCode::degenerate, if the edges were the cause.
  [[nodiscard]] Undetermined<kBlock> undetermined() const { return step_.undetermined(); }

  /// Linearises and factorises at the graph's values, for the covariances below.
  Result<void> prepare_covariances(const Graph& graph, const RobustKernel& kernel = {});

  /// The covariance of a variable, as a right perturbation of it, given the fixed ones; zero for
  /// those. Requires prepare_covariances on this graph.
  [[nodiscard]] Covariance covariance(int variable);
  /// The same of a variable of a factor graph, kDof × kDof.
  template <class X>
  [[nodiscard]] SquareOf<X> covariance(const VariableId<X>& variable) {
    constexpr int kDof = ManifoldTraits<X>::kDof;
    return covariance(variable.index).template topLeftCorner<kDof, kDof>();
  }

  /// prepare_covariances and the covariances of all poses, at the cost of two or three
  /// factorisations if the solver supports it (SelectedInverse). Afterwards `covariance`, and
  /// `relative_covariance` of poses that share an edge, are look-ups.
  Result<std::vector<Covariance>> covariances(const Graph& graph, const RobustKernel& kernel = {});

  /// The covariance of X_from⁻¹ X_to, as a right perturbation of it.
  [[nodiscard]] Covariance relative_covariance(const Graph& graph, int from,
                                               int to) requires LieGroup<typename Graph::Pose>;

 private:
  Result<void> run(Graph& graph, const OptimiseOptions& options, OptimiseReport& report);

  DampedStep<Graph, Solver> step_;
};

/// For pose graphs.
template <LieGroup G, LinearSolver Solver = DefaultSolver<ManifoldTraits<G>::kDof>>
using PoseGraphOptimiser = GraphOptimiser<PoseGraph<G>, Solver>;

/// Optimises one graph; for repeated calls use a GraphOptimiser.
template <class Graph>
Result<OptimiseReport> optimise(Graph& graph, const OptimiseOptions& options = {}) {
  return GraphOptimiser<Graph>().optimise(graph, options);
}

template <class Graph, LinearSolver S>
Result<OptimiseReport> GraphOptimiser<Graph, S>::optimise(Graph& graph,
                                                          const OptimiseOptions& options) {
  OptimiseReport report;
  step_.times() = {};
  if (auto done = run(graph, options, report); !done) return done.error();
  report.times = step_.times();
  return report;
}

template <class Graph, LinearSolver S>
Result<void> GraphOptimiser<Graph, S>::run(Graph& graph, const OptimiseOptions& options,
                                           OptimiseReport& report) {
  const PhaseTimer total(step_.times().total_s);
  step_.forget_outcome();
  {
    const PhaseTimer timer(step_.times().validate_s);
    if (auto valid = validate(graph); !valid) return valid;
  }
  step_.set_threads(options.threads);
  report.structure_reused = step_.prepare(graph);
  const typename Graph::Values start = graph.values();
  auto done = descend(step_, graph, options, report);
  if (done) done = check_determined(step_, graph);
  if (!done) graph.set_values(start);
  report.final_chi2 = step_.equations().chi2();
  return done;
}

template <class Graph, LinearSolver S>
Result<void> GraphOptimiser<Graph, S>::prepare_covariances(const Graph& graph,
                                                           const RobustKernel& kernel) {
  step_.forget_outcome();
  if (auto valid = validate(graph); !valid) return valid;
  step_.prepare(graph);
  step_.linearise(graph, kernel);
  if (step_.equations().free().empty() || step_.factorise()) return {};
  return step_.undetermined(graph);
}

template <class Graph, LinearSolver S>
auto GraphOptimiser<Graph, S>::covariance(int variable) -> Covariance {
  return joint_covariance(step_.equations(), step_.solver(), variable, variable)
      .template topLeftCorner<kBlock, kBlock>();
}

template <class Graph, LinearSolver S>
auto GraphOptimiser<Graph, S>::covariances(const Graph& graph, const RobustKernel& kernel)
    -> Result<std::vector<Covariance>> {
  if (auto prepared = prepare_covariances(graph, kernel); !prepared) return prepared.error();
  if constexpr (SelectedInverse<S>) {
    if (!step_.equations().free().empty()) step_.solver().invert();
  }
  std::vector<Covariance> all;
  all.reserve(static_cast<std::size_t>(graph.size()));
  for (int i = 0; i < graph.size(); ++i) {
    all.push_back(covariance(i));
    if (!all.back().allFinite())
      return Error{ErrorCode::numerical, "the covariance of " + graph.name(i) + " is not finite"};
  }
  return all;
}

template <class Graph, LinearSolver S>
auto GraphOptimiser<Graph, S>::relative_covariance(const Graph& graph, int from, int to)
    -> Covariance requires LieGroup<typename Graph::Pose> {
  const typename Graph::Pose between = graph.poses[static_cast<std::size_t>(from)].inverse() *
                                       graph.poses[static_cast<std::size_t>(to)];
  Eigen::Matrix<double, kBlock, 2 * kBlock> j;
  j << -between.inverse().adjoint(), Covariance::Identity();
  return j * joint_covariance(step_.equations(), step_.solver(), from, to) * j.transpose();
}

// Compiled once in wayfare::graph.
extern template class GraphOptimiser<PoseGraph2>;
extern template class GraphOptimiser<PoseGraph3>;

}  // namespace wayfare
