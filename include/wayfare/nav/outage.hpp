#pragma once

// Drift of a navigation system during satellite outages: repeated runs over one drive, each with
// most satellites removed during a different window (Zhang 2020, section 3.5.3).

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include <wayfare/core/contract.hpp>
#include <wayfare/core/parallel.hpp>
#include <wayfare/core/result.hpp>
#include <wayfare/gnss/single_point.hpp>
#include <wayfare/nav/gnss_ins.hpp>
#include <wayfare/sensors/measurements.hpp>
#include <wayfare/sensors/trajectory.hpp>

namespace wayfare {

/// The open interval from `begin` to `end`.
struct OutageWindow {
  LogTime begin,                    ///< satellites are removed after it
      end;                          ///< and before it
  std::size_t satellites_left = 0;  ///< number that stays
  /// Whether satellites are removed at this time.
  [[nodiscard]] bool contains(LogTime t) const { return t > begin && t < end; }
};

/// Horizontal error over the first part of an outage.
struct OutageError {
  double rmse_m = 0.0,      ///< horizontal
      max_m = 0.0;          ///< largest horizontal
  double end_m = 0.0;       ///< of the last estimate
  double distance_m = 0.0;  ///< travelled during the outage
};

/// Horizontal error at one instant of an outage.
struct DriftPoint {
  double time_s = 0.0,   ///< since its start
      distance_m = 0.0;  ///< travelled since its start
  double error_m = 0.0;  ///< horizontal
};

/// One outage of the longest duration.
struct OutageCourse {
  OutageWindow window;                   ///< the outage
  std::vector<DriftPoint> drift;         ///< at every estimate
  std::vector<OutageError> by_duration;  ///< in the order of the plan's durations
};

/// The mean over all starts.
struct OutageCell {
  Duration duration{0};             ///< from its start
  std::size_t satellites_left = 0;  ///< number that stayed
  OutageError mean;                 ///< of the errors of its outages
};

/// Errors over outages of several durations and numbers of satellites.
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

/// The outages of an experiment.
struct OutagePlan {
  /// Ascending.
  std::vector<Duration> durations = {std::chrono::seconds(10), std::chrono::seconds(15),
                                     std::chrono::seconds(20), std::chrono::seconds(25),
                                     std::chrono::seconds(30)};
  std::vector<std::size_t> satellites_left = {0, 1, 2, 3, 4};  ///< numbers of satellites that stay
  std::vector<LogTime> starts;                                 ///< start times of the outages
  int threads = 1;  ///< the report is the same for any number
};

/// `count` evenly spaced times such that an outage of `longest` ends by `last`.
[[nodiscard]] inline std::vector<LogTime> outage_starts(LogTime first, LogTime last,
                                                        Duration longest, std::size_t count) {
  std::vector<LogTime> starts;
  const Duration step =
      (last - first - longest) / std::max<std::int64_t>(1, std::int64_t(count) - 1);
  for (std::size_t i = 0; i < count; ++i)
    starts.push_back(first + static_cast<std::int64_t>(i) * step);
  return starts;
}

/// The same, each at the last of `epochs` before it, so that outages have their nominal length.
[[nodiscard]] inline std::vector<LogTime> outage_starts(LogTime first, LogTime last,
                                                        Duration longest, std::size_t count,
                                                        std::span<const RangeEpoch> epochs) {
  std::vector<LogTime> starts = outage_starts(first, last, longest, count);
  for (LogTime& start : starts) {
    const LogTime even = start;
    for (const RangeEpoch& e : epochs)
      if (e.time <= even) start = e.time;
  }
  return starts;
}

/// The epochs with at most `window.satellites_left` satellites within the window: the highest ones
/// at `receiver`, as between buildings. The selection is kept; others replace only missing ones.
[[nodiscard]] inline std::vector<RangeEpoch> mask_satellites(std::span<const RangeEpoch> epochs,
                                                             const OutageWindow& window,
                                                             const Geodetic& receiver) {
  const Eigen::Vector3d here = ecef_from_geodetic(receiver);
  const Eigen::Vector3d up = -rotation_ecef_ned(receiver).col(2);
  std::vector<SatelliteId> ranking;
  const auto rank = [&](const CorrectedRange& r) {
    return std::find(ranking.begin(), ranking.end(), r.satellite) - ranking.begin();
  };
  const auto elevation = [&](const CorrectedRange& r) {
    return up.dot((r.position_ecef_m - here).normalized());
  };
  std::vector<RangeEpoch> result(epochs.begin(), epochs.end());
  for (RangeEpoch& epoch : result) {
    if (!window.contains(epoch.time)) continue;
    auto& all = epoch.satellites;
    std::stable_sort(all.begin(), all.end(), [&](const auto& a, const auto& b) {
      return rank(a) != rank(b) ? rank(a) < rank(b) : elevation(a) > elevation(b);
    });
    for (const CorrectedRange& r : all)
      if (rank(r) == std::ptrdiff_t(ranking.size())) ranking.push_back(r.satellite);
    if (all.size() > window.satellites_left) all.resize(window.satellites_left);
  }
  return result;
}

/// Removes ranges as mask_satellites, and all fixes within the window whatever the number of
/// satellites left.
inline void apply_outage(const OutageWindow& window, GnssInsRecording& recording) {
  // The highest satellites are kept: that depends on the receiver's position.
  std::optional<Geodetic> receiver;
  for (const RangeEpoch& epoch : recording.ranges) {
    if (receiver && epoch.time > window.begin) break;
    if (const auto point = single_point(epoch)) receiver = point->position;
  }
  recording.ranges = mask_satellites(recording.ranges, window, receiver.value_or(Geodetic{}));
  std::erase_if(recording.fixes, [&](const GnssFix& f) { return window.contains(f.time); });
}

/// Runs a system through one outage and returns its estimates in order of time; those outside the
/// window may be omitted. Must be causal, so that one run of the longest outage covers the shorter
/// ones, and safe to call from several threads.
using OutageRun = std::function<Result<NavTrajectory>(const OutageWindow&)>;
/// The true state; safe to call from several threads.
using TrueState = std::function<NavState(LogTime)>;

namespace detail {

inline Result<OutageCourse> one_outage(const OutagePlan& plan, const OutageWindow& window,
                                       const OutageRun& run, const TrueState& truth) {
  const auto estimates = run(window);
  if (!estimates) return estimates.error();
  OutageCourse course{window, drift_during(window, *estimates, truth), {}};
  if (course.drift.empty() || course.drift.front().time_s >= to_seconds(plan.durations.front()))
    return Error{ErrorCode::not_found, "the system has no estimates within an outage"};
  for (const Duration d : plan.durations) course.by_duration.push_back(error_of(course.drift, d));
  return course;
}

inline OutageError mean_over_starts(const OutageReport& report, std::size_t first,
                                    std::size_t count, std::size_t duration) {
  OutageError mean;
  for (std::size_t i = first; i < first + count; ++i) {
    const OutageError& e = report.courses[i].by_duration[duration];
    const auto n = static_cast<double>(count);
    mean.rmse_m += e.rmse_m / n, mean.max_m += e.max_m / n;
    mean.end_m += e.end_m / n, mean.distance_m += e.distance_m / n;
  }
  return mean;
}

}  // namespace detail

/// Runs every number of satellites at every start. Fails with the first error of a run, or if a run
/// has no estimates within its window.
[[nodiscard]] inline Result<OutageReport> run_outages(
    const OutagePlan& plan, const OutageRun& run, const TrueState& truth,
    const std::function<void(double)>& progress = {}) {
  WAYFARE_EXPECTS(!plan.durations.empty() && !plan.satellites_left.empty() && !plan.starts.empty(),
                  "outages need a duration, a number of satellites and a start");
  const std::size_t starts = plan.starts.size(), runs = starts * plan.satellites_left.size();
  std::vector<std::optional<Result<OutageCourse>>> courses(runs);
  const auto one = [&](std::size_t i) {
    const LogTime begin = plan.starts[i % starts];
    courses[i] = detail::one_outage(
        plan, {begin, begin + plan.durations.back(), plan.satellites_left[i / starts]}, run, truth);
  };
  parallel_for(runs, plan.threads, one, progress);

  OutageReport report;
  for (auto& course : courses) {
    if (!*course) return course->error();
    report.courses.push_back(std::move(*course).value());
  }
  for (std::size_t d = 0; d < plan.durations.size(); ++d)
    for (std::size_t s = 0; s < plan.satellites_left.size(); ++s)
      report.cells.push_back({plan.durations[d], plan.satellites_left[s],
                              detail::mean_over_starts(report, s * starts, starts, d)});
  return report;
}

}  // namespace wayfare
