#pragma once

// After each step of an optimisation: record, termination.

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

}  // namespace wayfare
