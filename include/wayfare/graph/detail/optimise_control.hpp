#pragma once

// What an optimisation does after a step: record it, ask whether to go on, adapt the damping.

#include <algorithm>
#include <cmath>

#include <wayfare/graph/report.hpp>

namespace wayfare {

/// λ of Levenberg-Marquardt as in Nielsen 1999 (Madsen, Nielsen, Tingleff 2004, algorithm 3.16).
class Damping {
 public:
  explicit Damping(double start) : value_(start) {}

  [[nodiscard]] double value() const { return value_; }
  /// After a step that lowered the cost by `quality` times what the model promised.
  void step_taken(double quality) {
    value_ *= std::max(1.0 / 3.0, 1.0 - std::pow(2.0 * quality - 1.0, 3));
    growth_ = 2.0;
  }
  void step_refused() {
    value_ *= growth_;
    growth_ *= 2.0;
  }

 private:
  double value_;
  double growth_ = 2.0;
};

/// Keeps a report's history and says when it is time to stop, and why.
class OptimiseControl {
 public:
  /// Both must outlive it.
  OptimiseControl(const OptimiseOptions& options, OptimiseReport& report)
      : options_(options), report_(report) {}

  [[nodiscard]] bool may_iterate() const { return report_.iterations < options_.max_iterations; }

  /// A step that took the cost to record.cost; true where that ends the optimisation.
  bool taken(double cost_before, const IterationRecord& record) {
    if (!goes_on(record)) return true;
    const double gain = cost_before - record.cost;
    if (gain > options_.min_relative_gain * cost_before && gain > options_.min_absolute_gain) {
      return false;
    }
    report_.reason = StopReason::converged;
    return true;
  }

  /// A step that was not taken; true where the caller wants no more.
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

}  // namespace wayfare
