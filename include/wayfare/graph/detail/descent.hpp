#pragma once

// Minimisation of Σ ρ(eᵀΩe) by Gauss-Newton (H Δ = −g) and Levenberg-Marquardt
// ((H + λ diag H) Δ = −g). Before and after, `step` is linearised at the graph's poses.

#include <cmath>
#include <limits>
#include <optional>

#include <wayfare/core/levenberg_marquardt.hpp>
#include <wayfare/core/result.hpp>
#include <wayfare/graph/detail/damped_step.hpp>
#include <wayfare/graph/detail/validate.hpp>
#include <wayfare/graph/report.hpp>

namespace wayfare {

/// Records a report's history and decides when and why to stop.
class OptimiseControl {
 public:
  /// Both must outlive it.
  OptimiseControl(const OptimiseOptions& options, OptimiseReport& report)
      : options_(options), report_(report) {}

  [[nodiscard]] bool may_iterate() const { return report_.iterations < options_.max_iterations; }

  /// After an accepted step; true if the optimisation ends.
  bool taken(double cost_before, const IterationRecord& record) {
    if (!goes_on(record)) return true;
    const double gain = cost_before - record.cost;
    if (gain > options_.min_relative_gain * cost_before && gain > options_.min_absolute_gain) {
      return false;
    }
    report_.reason = StopReason::converged;
    return true;
  }

  /// After a rejected step; true if the progress callback stops the optimisation.
  bool refused(double damping) { return !goes_on({report_.final_cost, damping, 0.0, false}); }

 private:
  bool goes_on(const IterationRecord& record) {
    report_.history.push_back(record);
    const int number = static_cast<int>(report_.history.size());
    if (!options_.progress || options_.progress(number, record)) return true;
    report_.reason = StopReason::stopped;
    return false;
  }

  const OptimiseOptions& options_;
  OptimiseReport& report_;
};

/// Full steps, after which the cost may lie above the lowest for a few steps: where first errors
/// are large, the way to the minimum leads over a rise (non-monotone Gauss-Newton, Grippo et al.
/// 1986). False if a step could not be computed or the cost did not fall again: the poses are then
/// those of the lowest cost.
template <class Graph, LinearSolver S>
bool gauss_newton(DampedStep<Graph, S>& step, Graph& graph, const OptimiseOptions& options,
                  OptimiseReport& report) {
  OptimiseControl control(options, report);
  std::optional<typename Graph::Values> lowest;  // while the cost is above report.final_cost
  int rises = 0;
  double before = report.final_cost;
  const auto return_to_lowest = [&] {
    if (!lowest) return;
    graph.set_values(*lowest);
    step.linearise(graph, options.kernel);
  };
  while (control.may_iterate()) {
    if (!step.compute(0.0)) {
      return_to_lowest();
      return false;
    }
    ++report.iterations;
    step.apply(graph);
    const double after = step.linearise(graph, options.kernel);
    if (after <= report.final_cost) {
      report.final_cost = after;
      lowest.reset();
      rises = 0;
      if (control.taken(before, {after, 0.0, step.largest(), true})) return true;
      before = after;
      continue;
    }
    if (!lowest) lowest = step.before();
    const bool at_rounding = after - before <= options.min_relative_gain * before && rises == 0;
    const bool stopped = control.refused(0.0);
    before = after;
    if (at_rounding || stopped || !std::isfinite(after) || ++rises > options.max_rises) {
      return_to_lowest();
      if (at_rounding) report.reason = StopReason::converged;
      return at_rounding || stopped;
    }
  }
  return_to_lowest();
  report.reason = StopReason::max_iterations;
  return true;
}

/// A loop of its own beside core's: it counts only the iterations that were completed, reports each
/// to the caller, takes steps that leave the cost as it is, and names what is not determined.
/// Damping is scaled by the diagonal of H so that metres and radians are damped alike. Error if the
/// poses are undetermined at every damping.
template <class Graph, LinearSolver S>
Result<void> levenberg_marquardt(DampedStep<Graph, S>& step, Graph& graph,
                                 const OptimiseOptions& options, OptimiseReport& report) {
  OptimiseControl control(options, report);
  NielsenDamping damping(options.initial_damping, options.max_damping);
  bool ever_solved = false;
  report.reason = StopReason::max_iterations;
  for (; control.may_iterate(); ++report.iterations) {
    const bool solved = step.compute(damping.value());
    ever_solved = ever_solved || solved;
    const double before = report.final_cost;
    if (solved && step.model_gain() <= options.min_relative_gain * 1e-3 * before) {
      report.reason = StopReason::converged;
      return {};
    }
    if (solved) step.apply(graph);
    const double after =
        solved ? step.cost(graph, options.kernel) : std::numeric_limits<double>::infinity();
    if (solved && after <= before) {
      report.final_cost = step.linearise(graph, options.kernel);
      if (control.taken(before, {after, damping.value(), step.largest(), true})) {
        ++report.iterations;
        return {};
      }
      damping.step_taken((before - after) / step.model_gain());
      continue;
    }
    if (solved) step.undo(graph);
    if (control.refused(damping.value())) return {};
    damping.step_refused();
    if (damping.exhausted()) {
      report.reason = StopReason::no_progress;
      break;
    }
  }
  if (!ever_solved && !step.solved()) return step.undetermined(graph);
  return {};
}

/// Minimises from the graph's poses: Gauss-Newton, or Levenberg-Marquardt if it is asked for or a
/// full step fails. Errors: a cost that overflows, and those of levenberg_marquardt.
template <class Graph, LinearSolver S>
Result<void> descend(DampedStep<Graph, S>& step, Graph& graph, const OptimiseOptions& options,
                     OptimiseReport& report) {
  report.initial_cost = report.final_cost = step.linearise(graph, options.kernel);
  report.initial_chi2 = step.equations().chi2();
  if (!std::isfinite(report.initial_cost) || !step.equations().gradient().allFinite())
    return cost_overflow(graph);
  if (step.equations().free().empty()) return {};
  const bool damped = options.method == OptimiseMethod::levenberg_marquardt;
  if (!damped && gauss_newton(step, graph, options, report)) return {};
  report.fell_back = !damped;
  return levenberg_marquardt(step, graph, options, report);
}

/// An Error if the edges leave a pose undetermined at the end of the descent, where `step` is
/// linearised. Factorises again only if the last factorisation is inconclusive.
template <class Graph, LinearSolver S>
Result<void> check_determined(DampedStep<Graph, S>& step, const Graph& graph) {
  if (step.equations().free().empty() || step.determined() || step.factorise()) return {};
  return step.undetermined(graph);
}

}  // namespace wayfare
