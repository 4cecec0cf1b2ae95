#pragma once

// Drift of a navigation system during satellite outages.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>
#include <vector>

#include <Eigen/Core>

#include <wayfare/core/contract.hpp>
#include <wayfare/sensors/nav_state.hpp>

namespace wayfare {

/// The open interval from `begin` to `end`.
struct OutageWindow {
  LogTime begin, end;
  std::size_t satellites_left = 0;
  [[nodiscard]] bool contains(LogTime t) const { return t > begin && t < end; }
};

/// Horizontal error over the first part of an outage.
struct OutageError {
  double rmse_m = 0.0, max_m = 0.0;
  double end_m = 0.0;       ///< of the last estimate
  double distance_m = 0.0;  ///< travelled during the outage
};

/// Horizontal error at one instant of an outage.
struct DriftPoint {
  double time_s = 0.0, distance_m = 0.0;  ///< since its start
  double error_m = 0.0;
};

/// One outage of the longest duration.
struct OutageCourse {
  OutageWindow window;
  std::vector<DriftPoint> drift;         ///< at every estimate
  std::vector<OutageError> by_duration;  ///< in the order of the plan's durations
};

/// The mean over all starts.
struct OutageCell {
  Duration duration{0};
  std::size_t satellites_left = 0;
  OutageError mean;
};

struct OutageReport {
  std::vector<OutageCell> cells;      ///< by duration, then by satellites left
  std::vector<OutageCourse> courses;  ///< by satellites left, then by start

  /// Must be in the plan.
  [[nodiscard]] const OutageError& mean(Duration duration, std::size_t satellites_left) const {
    for (const OutageCell& c : cells)
      if (c.duration == duration && c.satellites_left == satellites_left) return c.mean;
    WAYFARE_EXPECTS(false, "the report has no such outage");
    return cells.front().mean;
  }
};

/// Error and distance at every estimate within the window; `truth` maps a time to a NavState.
template <class Truth>
[[nodiscard]] std::vector<DriftPoint> drift_during(const OutageWindow& window,
                                                   std::span<const NavState> estimates,
                                                   const Truth& truth) {
  std::vector<DriftPoint> drift;
  NavState before = truth(window.begin);
  double distance = 0.0;
  for (const NavState& e : estimates) {
    if (!window.contains(e.time)) continue;
    const NavState now = truth(e.time);
    distance += ned_from_geodetic(now.position, before.position).norm();
    drift.push_back({to_seconds(e.time - window.begin), distance,
                     ned_from_geodetic(e.position, now.position).head<2>().norm()});
    before = now;
  }
  return drift;
}

/// Error over the drift before `duration`.
[[nodiscard]] inline OutageError error_of(std::span<const DriftPoint> drift, Duration duration) {
  OutageError error;
  double squares = 0.0, count = 0.0;
  for (const DriftPoint& p : drift) {
    if (p.time_s >= to_seconds(duration)) break;
    squares += p.error_m * p.error_m, count += 1.0;
    error.max_m = std::max(error.max_m, p.error_m);
    error.end_m = p.error_m, error.distance_m = p.distance_m;
  }
  error.rmse_m = std::sqrt(squares / count);
  return error;
}

}  // namespace wayfare
