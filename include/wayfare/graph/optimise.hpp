#pragma once

// x* = argmin Σ ρ(eᵀΩe) on a pose graph, and the covariance of x*.

#include <vector>

#include <wayfare/graph/detail/descent.hpp>
#include <wayfare/graph/detail/validate.hpp>
#include <wayfare/graph/linear_solver.hpp>

namespace wayfare {

template <int N>
using DefaultSolver = MultifrontalCholesky<N>;

/// Optimises pose graphs. Reuses pattern, symbolic factorisation and memory between calls while the
/// structure is unchanged.
template <LieGroup G, LinearSolver Solver = DefaultSolver<ManifoldTraits<G>::kDof>>
class PoseGraphOptimiser {
 public:
  static constexpr int kDof = ManifoldTraits<G>::kDof;

  /// Moves the free poses of `graph` to a local minimum near their initial values. Errors, with the
  /// poses unchanged: those of validate, errors too large to square, a pose that the edges leave
  /// undetermined at the minimum (reported by `undetermined`).
  Result<OptimiseReport> optimise(PoseGraph<G>& graph, const OptimiseOptions& options = {});

  /// The undetermined pose and direction of the last call that failed with ErrorCode::degenerate,
  /// if the edges were the cause.
  [[nodiscard]] UndeterminedPose<G> undetermined() const { return step_.undetermined(); }

  /// Linearises and factorises at the graph's poses, for the covariances below.
  Result<void> prepare_covariances(const PoseGraph<G>& graph, const RobustKernel& kernel = {});

  /// The covariance of a pose, as a right perturbation of it, given the fixed poses; zero for
  /// those. Requires prepare_covariances on this graph.
  [[nodiscard]] SquareOf<G> covariance(int pose);

  /// prepare_covariances and the covariances of all poses, at the cost of two or three
  /// factorisations if the solver supports it (SelectedInverse). Afterwards `covariance`, and
  /// `relative_covariance` of poses that share an edge, are look-ups.
  Result<std::vector<SquareOf<G>>> covariances(const PoseGraph<G>& graph,
                                               const RobustKernel& kernel = {});

  /// The covariance of X_from⁻¹ X_to, as a right perturbation of it.
  [[nodiscard]] SquareOf<G> relative_covariance(const PoseGraph<G>& graph, int from, int to);

 private:
  Result<void> run(PoseGraph<G>& graph, const OptimiseOptions& options, OptimiseReport& report);

  DampedStep<G, Solver> step_;
};

/// Optimises one graph; for repeated calls use a PoseGraphOptimiser.
template <LieGroup G>
Result<OptimiseReport> optimise(PoseGraph<G>& graph, const OptimiseOptions& options = {}) {
  return PoseGraphOptimiser<G>().optimise(graph, options);
}

template <LieGroup G, LinearSolver S>
Result<OptimiseReport> PoseGraphOptimiser<G, S>::optimise(PoseGraph<G>& graph,
                                                          const OptimiseOptions& options) {
  OptimiseReport report;
  step_.times() = {};
  if (auto done = run(graph, options, report); !done) return done.error();
  report.times = step_.times();
  return report;
}

template <LieGroup G, LinearSolver S>
Result<void> PoseGraphOptimiser<G, S>::run(PoseGraph<G>& graph, const OptimiseOptions& options,
                                           OptimiseReport& report) {
  const PhaseTimer total(step_.times().total_s);
  step_.forget_outcome();
  {
    const PhaseTimer timer(step_.times().validate_s);
    if (auto valid = validate(graph); !valid) return valid;
  }
  step_.set_threads(options.threads);
  report.structure_reused = step_.prepare(graph);
  const std::vector<G> start = graph.poses;
  auto done = descend(step_, graph, options, report);
  if (done) done = check_determined(step_, graph);
  if (!done) graph.poses = start;
  report.final_chi2 = step_.equations().chi2();
  return done;
}

template <LieGroup G, LinearSolver S>
Result<void> PoseGraphOptimiser<G, S>::prepare_covariances(const PoseGraph<G>& graph,
                                                           const RobustKernel& kernel) {
  step_.forget_outcome();
  if (auto valid = validate(graph); !valid) return valid;
  step_.prepare(graph);
  step_.linearise(graph, kernel);
  if (step_.equations().free_poses().empty() || step_.factorise()) return {};
  return step_.undetermined(graph);
}

template <LieGroup G, LinearSolver S>
SquareOf<G> PoseGraphOptimiser<G, S>::covariance(int pose) {
  return joint_covariance(step_.equations(), step_.solver(), pose, pose)
      .template topLeftCorner<kDof, kDof>();
}

template <LieGroup G, LinearSolver S>
Result<std::vector<SquareOf<G>>> PoseGraphOptimiser<G, S>::covariances(const PoseGraph<G>& graph,
                                                                       const RobustKernel& kernel) {
  if (auto prepared = prepare_covariances(graph, kernel); !prepared) return prepared.error();
  if constexpr (SelectedInverse<S>) {
    if (!step_.equations().free_poses().empty()) step_.solver().invert();
  }
  std::vector<SquareOf<G>> all;
  all.reserve(graph.poses.size());
  for (int pose = 0; pose < graph.size(); ++pose) all.push_back(covariance(pose));
  return all;
}

template <LieGroup G, LinearSolver S>
SquareOf<G> PoseGraphOptimiser<G, S>::relative_covariance(const PoseGraph<G>& graph, int from,
                                                          int to) {
  const G between = graph.poses[static_cast<std::size_t>(from)].inverse() *
                    graph.poses[static_cast<std::size_t>(to)];
  Eigen::Matrix<double, kDof, 2 * kDof> j;
  j << -between.inverse().adjoint(), SquareOf<G>::Identity();
  return j * joint_covariance(step_.equations(), step_.solver(), from, to) * j.transpose();
}

// Compiled once in wayfare::graph.
extern template class PoseGraphOptimiser<SE2d>;
extern template class PoseGraphOptimiser<SE3d>;

}  // namespace wayfare
