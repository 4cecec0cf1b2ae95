#pragma once

// x* = argmin Σ ρ(eᵀΩe): Gauss-Newton (H Δx = −g) and Levenberg-Marquardt
// ((H + λ diag H) Δx = −g) on a pose graph.

#include <chrono>
#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include <wayfare/graph/block_cholesky.hpp>
#include <wayfare/graph/linear_solver.hpp>
#include <wayfare/graph/normal_equations.hpp>
#include <wayfare/graph/report.hpp>
#include <wayfare/graph/validate.hpp>

namespace wayfare {

template <int N>
using DefaultSolver = BlockCholesky<N>;

/// Optimises pose graphs, keeping pattern, symbolic factorisation and memory from one call to the
/// next while the structure stays the same: keep one for a graph that grows.
template <LieGroup G, LinearSolver Solver = DefaultSolver<ManifoldTraits<G>::kDof>>
class PoseGraphOptimiser {
 public:
  static constexpr int kDof = ManifoldTraits<G>::kDof;

  /// Moves the free poses of `graph` to a local minimum near where they are. On failure
  /// (validate's faults, or a pose the edges leave undetermined) the poses are untouched.
  Result<OptimiseReport> optimise(PoseGraph<G>& graph, const OptimiseOptions& options = {});

  /// Linearises and factorises at the graph's poses, for the covariances below.
  Result<void> prepare_covariances(const PoseGraph<G>& graph, const RobustKernel& kernel = {});

  /// The covariance of a pose, as a right perturbation of it, given that the fixed poses are exact;
  /// zero for those. Needs prepare_covariances on this graph.
  [[nodiscard]] SquareOf<G> covariance(int pose) {
    return joint_covariance(pose, pose).template topLeftCorner<kDof, kDof>();
  }

  /// The covariance of X_from⁻¹ X_to, as a right perturbation of it.
  [[nodiscard]] SquareOf<G> relative_covariance(const PoseGraph<G>& graph, int from, int to);

 private:
  using Clock = std::chrono::steady_clock;
  using Joint = Eigen::Matrix<double, 2 * kDof, 2 * kDof>;

  /// Adds the time until its end to a phase.
  class Timer {
   public:
    explicit Timer(double& seconds) : seconds_(seconds) {}
    Timer(const Timer&) = delete;
    ~Timer() { seconds_ += std::chrono::duration<double>(Clock::now() - start_).count(); }

   private:
    double& seconds_;
    Clock::time_point start_ = Clock::now();
  };

  struct Step {
    FactorOutcome outcome;
    double model_gain = 0.0;  // how much the quadratic model falls along step_
  };

  void prepare(const PoseGraph<G>& graph, OptimiseReport& report);
  double linearise(const PoseGraph<G>& graph, const OptimiseOptions& options);
  Step compute_step(double damping);
  void damp_diagonal(double damping);
  void restore_diagonal();
  void apply_step(PoseGraph<G>& graph);
  bool gauss_newton(PoseGraph<G>& graph, const OptimiseOptions& options, OptimiseReport& report);
  Result<void> levenberg_marquardt(PoseGraph<G>& graph, const OptimiseOptions& options,
                                   OptimiseReport& report);
  bool finished(const OptimiseOptions& options, OptimiseReport& report, double before,
                const IterationRecord& record);
  bool record_refused(const OptimiseOptions& options, OptimiseReport& report, double damping);
  bool goes_on(const OptimiseOptions& options, OptimiseReport& report,
               const IterationRecord& record);
  Error undetermined(const PoseGraph<G>& graph, FactorOutcome outcome) const;
  Joint joint_covariance(int a, int b);

  NormalEquations<G> equations_;
  Solver solver_;
  PhaseTimes times_;
  std::vector<G> saved_;
  Eigen::VectorXd step_, diagonal_;
};

/// One call for one graph; keep a PoseGraphOptimiser where there will be more.
template <LieGroup G>
Result<OptimiseReport> optimise(PoseGraph<G>& graph, const OptimiseOptions& options = {}) {
  return PoseGraphOptimiser<G>().optimise(graph, options);
}

template <LieGroup G, LinearSolver S>
Result<OptimiseReport> PoseGraphOptimiser<G, S>::optimise(PoseGraph<G>& graph,
                                                          const OptimiseOptions& options) {
  OptimiseReport report;
  times_ = {};
  {
    const Timer total(times_.total_s);
    {
      const Timer timer(times_.validate_s);
      if (auto valid = validate(graph); !valid) return valid.error();
    }
    prepare(graph, report);
    report.initial_chi2 = chi2(graph);
    const std::vector<G> start = graph.poses;
    report.initial_cost = report.final_cost = linearise(graph, options);
    if (!equations_.free_poses().empty()) {
      const bool damped = options.method == OptimiseMethod::levenberg_marquardt;
      report.fell_back = !damped && !gauss_newton(graph, options, report);
      if (damped || report.fell_back) {
        if (auto done = levenberg_marquardt(graph, options, report); !done) {
          graph.poses = start;
          return done.error();
        }
      }
    }
    report.final_chi2 = chi2(graph);
  }
  report.times = times_;
  return report;
}

template <LieGroup G, LinearSolver S>
void PoseGraphOptimiser<G, S>::prepare(const PoseGraph<G>& graph, OptimiseReport& report) {
  const Timer timer(times_.analyse_s);
  report.structure_reused = !equations_.set_structure(graph);
  if (!report.structure_reused) solver_.analyse(equations_.hessian());
}

template <LieGroup G, LinearSolver S>
double PoseGraphOptimiser<G, S>::linearise(const PoseGraph<G>& graph,
                                           const OptimiseOptions& options) {
  const Timer timer(times_.linearise_s);
  return equations_.linearise(graph, options.kernel);
}

template <LieGroup G, LinearSolver S>
auto PoseGraphOptimiser<G, S>::compute_step(double damping) -> Step {
  Step result;
  {
    const Timer timer(times_.factorise_s);
    if (damping > 0.0) damp_diagonal(damping);
    result.outcome = solver_.factorise(equations_.hessian());
    if (damping > 0.0) restore_diagonal();
  }
  if (!result.outcome.ok) return result;
  const Timer timer(times_.solve_s);
  step_ = -equations_.gradient();
  solver_.solve_in_place(step_);
  // (H + λD)Δ = −g, so the model falls by −2gᵀΔ − ΔᵀHΔ = −gᵀΔ + λ ΔᵀDΔ.
  result.model_gain = -equations_.gradient().dot(step_);
  if (damping > 0.0) result.model_gain += damping * step_.cwiseAbs2().dot(diagonal_);
  if (!step_.allFinite()) result.outcome.ok = false;
  return result;
}

template <LieGroup G, LinearSolver S>
void PoseGraphOptimiser<G, S>::damp_diagonal(double damping) {
  auto& h = equations_.hessian();
  diagonal_.resize(equations_.gradient().size());
  for (int c = 0; c < h.columns(); ++c) {
    auto block = h.block(h.diagonal_index(c));
    diagonal_.template segment<kDof>(c * kDof) = block.diagonal();
    block.diagonal() *= 1.0 + damping;
  }
}

template <LieGroup G, LinearSolver S>
void PoseGraphOptimiser<G, S>::restore_diagonal() {
  auto& h = equations_.hessian();
  for (int c = 0; c < h.columns(); ++c) {
    h.block(h.diagonal_index(c)).diagonal() = diagonal_.template segment<kDof>(c * kDof);
  }
}

template <LieGroup G, LinearSolver S>
void PoseGraphOptimiser<G, S>::apply_step(PoseGraph<G>& graph) {
  saved_ = graph.poses;
  int column = 0;
  for (const int pose : equations_.free_poses()) {
    G& x = graph.poses[static_cast<std::size_t>(pose)];
    x = ManifoldTraits<G>::plus(x, step_.template segment<kDof>(kDof * column++));
  }
}

/// False when a full step could not be computed or did not lower the cost: the poses are then those
/// before it, linearised.
template <LieGroup G, LinearSolver S>
bool PoseGraphOptimiser<G, S>::gauss_newton(PoseGraph<G>& graph, const OptimiseOptions& options,
                                            OptimiseReport& report) {
  while (report.iterations < options.max_iterations) {
    if (!compute_step(0.0).outcome.ok) return false;
    ++report.iterations;
    apply_step(graph);
    const double before = report.final_cost;
    const double after = linearise(graph, options);
    if (!(after <= before)) {  // NaN too
      graph.poses = saved_;
      linearise(graph, options);
      const bool at_rounding = after - before <= options.min_relative_gain * before;
      report.reason = StopReason::converged;
      if (!record_refused(options, report, 0.0) || at_rounding) return true;
      return false;
    }
    report.final_cost = after;
    if (finished(options, report, before, {after, 0.0, step_.cwiseAbs().maxCoeff(), true})) {
      return true;
    }
  }
  report.reason = StopReason::max_iterations;
  return true;
}

/// Damping as in Nielsen 1999 (Madsen, Nielsen, Tingleff 2004, algorithm 3.16), scaled by the
/// diagonal of H so that metres and radians are damped alike.
template <LieGroup G, LinearSolver S>
Result<void> PoseGraphOptimiser<G, S>::levenberg_marquardt(PoseGraph<G>& graph,
                                                           const OptimiseOptions& options,
                                                           OptimiseReport& report) {
  double damping = options.initial_damping;
  double growth = 2.0;
  FactorOutcome last;
  bool ever_solved = false;
  for (; report.iterations < options.max_iterations; ++report.iterations) {
    const Step step = compute_step(damping);
    last = step.outcome;
    ever_solved = ever_solved || last.ok;
    double after = std::numeric_limits<double>::infinity();
    const double before = report.final_cost;
    if (last.ok) {
      if (step.model_gain <= options.min_relative_gain * 1e-3 * before) {
        report.reason = StopReason::converged;
        return {};
      }
      apply_step(graph);
      after = robust_cost(graph, options.kernel);
    }
    if (after <= before) {
      const double quality = (before - after) / step.model_gain;
      report.final_cost = linearise(graph, options);
      if (finished(options, report, before, {after, damping, step_.cwiseAbs().maxCoeff(), true})) {
        ++report.iterations;
        return {};
      }
      damping *= std::max(1.0 / 3.0, 1.0 - std::pow(2.0 * quality - 1.0, 3));
      growth = 2.0;
      continue;
    }
    if (last.ok) graph.poses = saved_;
    if (!record_refused(options, report, damping)) return {};
    damping *= growth;
    growth *= 2.0;
    if (damping > options.max_damping) {
      if (!ever_solved) return undetermined(graph, last);
      report.reason = StopReason::no_progress;
      return {};
    }
  }
  if (!ever_solved) return undetermined(graph, last);
  report.reason = StopReason::max_iterations;
  return {};
}

template <LieGroup G, LinearSolver S>
bool PoseGraphOptimiser<G, S>::finished(const OptimiseOptions& options, OptimiseReport& report,
                                        double before, const IterationRecord& record) {
  if (!goes_on(options, report, record)) return true;
  const double gain = before - record.cost;
  if (gain > options.min_relative_gain * before && gain > options.min_absolute_gain) return false;
  report.reason = StopReason::converged;
  return true;
}

template <LieGroup G, LinearSolver S>
bool PoseGraphOptimiser<G, S>::record_refused(const OptimiseOptions& options,
                                              OptimiseReport& report, double damping) {
  return goes_on(options, report, {report.final_cost, damping, 0.0, false});
}

template <LieGroup G, LinearSolver S>
bool PoseGraphOptimiser<G, S>::goes_on(const OptimiseOptions& options, OptimiseReport& report,
                                       const IterationRecord& record) {
  report.history.push_back(record);
  const int number = static_cast<int>(report.history.size());
  if (!options.progress || options.progress(number, record)) return true;
  report.reason = StopReason::stopped;
  return false;
}

template <LieGroup G, LinearSolver S>
Error PoseGraphOptimiser<G, S>::undetermined(const PoseGraph<G>& graph,
                                             FactorOutcome outcome) const {
  if (outcome.block < 0) return {ErrorCode::degenerate, "the edges do not determine every pose"};
  const int pose = equations_.free_poses()[static_cast<std::size_t>(outcome.block)];
  return {ErrorCode::degenerate,
          "pose " + graph.label(pose) + " is not fully determined by the edges"};
}

template <LieGroup G, LinearSolver S>
Result<void> PoseGraphOptimiser<G, S>::prepare_covariances(const PoseGraph<G>& graph,
                                                           const RobustKernel& kernel) {
  if (auto valid = validate(graph); !valid) return valid;
  OptimiseReport ignored;
  prepare(graph, ignored);
  equations_.linearise(graph, kernel);
  if (equations_.free_poses().empty()) return {};
  const FactorOutcome outcome = solver_.factorise(equations_.hessian());
  if (!outcome.ok) return undetermined(graph, outcome);
  return {};
}

template <LieGroup G, LinearSolver S>
auto PoseGraphOptimiser<G, S>::joint_covariance(int a, int b) -> Joint {
  Joint joint = Joint::Zero();
  const int columns[2] = {equations_.free_index(a), equations_.free_index(b)};
  for (int side = 0; side < 2; ++side) {
    if (columns[side] < 0) continue;
    for (int k = 0; k < kDof; ++k) {
      step_.setZero(equations_.gradient().size());
      step_[columns[side] * kDof + k] = 1.0;
      solver_.solve_in_place(step_);
      for (int row = 0; row < 2; ++row) {
        if (columns[row] < 0) continue;
        joint.template block<kDof, 1>(row * kDof, side * kDof + k) =
            step_.template segment<kDof>(columns[row] * kDof);
      }
    }
  }
  return joint;
}

template <LieGroup G, LinearSolver S>
SquareOf<G> PoseGraphOptimiser<G, S>::relative_covariance(const PoseGraph<G>& graph, int from,
                                                          int to) {
  const Joint joint = joint_covariance(from, to);
  const G between = graph.poses[static_cast<std::size_t>(from)].inverse() *
                    graph.poses[static_cast<std::size_t>(to)];
  Eigen::Matrix<double, kDof, 2 * kDof> j;
  j << -between.inverse().adjoint(), SquareOf<G>::Identity();
  return j * joint * j.transpose();
}

// Compiled once in wayfare::slam.
extern template class PoseGraphOptimiser<SE2d>;
extern template class PoseGraphOptimiser<SE3d>;

}  // namespace wayfare
