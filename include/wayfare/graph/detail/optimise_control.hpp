#pragma once

// After each step of an optimisation: record, termination, damping.

#include <algorithm>
#include <cmath>

#include <wayfare/graph/report.hpp>

namespace wayfare {

/// λ of Levenberg-Marquardt as in Nielsen 1999 (Madsen, Nielsen, Tingleff 2004, algorithm 3.16).
class Damping {
 public:
  explicit Damping(double start) : value_(start) {}

  [[nodiscard]] double value() const { return value_; }
  /// After an accepted step with gain ratio `quality` (actual over predicted decrease).
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

}  // namespace wayfare
