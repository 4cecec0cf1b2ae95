#pragma once

// What satellite outages do to a navigation system: the same drive again and again, each time with
// most satellites taken away for a while at another place (Zhang 2020, section 3.5.3).

#include <algorithm>
#include <cstddef>
#include <functional>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include <wayfare/core/parallel.hpp>
#include <wayfare/core/result.hpp>
#include <wayfare/nav/outage_errors.hpp>
#include <wayfare/sensors/gnss.hpp>

namespace wayfare {

struct OutagePlan {
  /// Ascending.
  std::vector<Duration> durations = {std::chrono::seconds(10), std::chrono::seconds(15),
                                     std::chrono::seconds(20), std::chrono::seconds(25),
                                     std::chrono::seconds(30)};
  std::vector<std::size_t> satellites_left = {0, 1, 2, 3, 4};
  std::vector<LogTime> places;  ///< where outages begin
  int threads = 1;              ///< the report is the same for any number
};

/// `count` times spread evenly so that an outage of `longest` ends by `last` from each.
[[nodiscard]] inline std::vector<LogTime> outage_places(LogTime first, LogTime last,
                                                        Duration longest, std::size_t count) {
  std::vector<LogTime> places;
  const Duration step =
      (last - first - longest) / std::max<std::int64_t>(1, std::int64_t(count) - 1);
  for (std::size_t i = 0; i < count; ++i)
    places.push_back(first + static_cast<std::int64_t>(i) * step);
  return places;
}

/// The epochs with no more satellites in the window than it leaves: those that stand highest over
/// `receiver`, as between buildings. A satellite that is left stays left: others step in only where
/// one of them is missing.
[[nodiscard]] inline std::vector<RangeEpoch> take_satellites(std::span<const RangeEpoch> epochs,
                                                             const OutageWindow& window,
                                                             const Geodetic& receiver) {
  const Eigen::Vector3d here = ecef_from_geodetic(receiver);
  const Eigen::Vector3d up = -rotation_ecef_ned(receiver).col(2);
  std::vector<SatelliteId> ranking;
  const auto rank = [&](const CorrectedRange& r) {
    return std::find(ranking.begin(), ranking.end(), r.satellite) - ranking.begin();
  };
  const auto height = [&](const CorrectedRange& r) {
    return up.dot((r.position_ecef_m - here).normalized());
  };
  std::vector<RangeEpoch> result(epochs.begin(), epochs.end());
  for (RangeEpoch& epoch : result) {
    if (!window.contains(epoch.time)) continue;
    auto& all = epoch.satellites;
    std::stable_sort(all.begin(), all.end(), [&](const auto& a, const auto& b) {
      return rank(a) != rank(b) ? rank(a) < rank(b) : height(a) > height(b);
    });
    for (const CorrectedRange& r : all)
      if (rank(r) == std::ptrdiff_t(ranking.size())) ranking.push_back(r.satellite);
    if (all.size() > window.satellites_left) all.resize(window.satellites_left);
  }
  return result;
}

/// Takes a system through one outage and returns what it put out, in order of time; estimates
/// outside of the window may be left out. Must be causal and safe to call from several threads:
/// since nothing it says within an outage depends on when that ends, one run through the longest
/// answers for the shorter ones too.
using OutageRun = std::function<Result<NavTrajectory>(const OutageWindow&)>;
/// Where the system truly was; safe to call from several threads.
using TrueState = std::function<NavState(LogTime)>;

namespace detail {

inline Result<OutageCourse> one_outage(const OutagePlan& plan, const OutageWindow& window,
                                       const OutageRun& run, const TrueState& truth) {
  const auto estimates = run(window);
  if (!estimates) return estimates.error();
  OutageCourse course{window, drift_through(window, *estimates, truth), {}};
  if (course.drift.empty() || course.drift.front().time_s >= to_seconds(plan.durations.front()))
    return Error{ErrorCode::not_found, "the system says nothing within an outage"};
  for (const Duration d : plan.durations) course.by_duration.push_back(error_of(course.drift, d));
  return course;
}

inline OutageError mean_over_places(const OutageReport& report, std::size_t first,
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

/// Every number of satellites left at every place. Fails with the first of the runs' errors, and
/// where a run says nothing within its window.
[[nodiscard]] inline Result<OutageReport> run_outages(
    const OutagePlan& plan, const OutageRun& run, const TrueState& truth,
    const std::function<void(double)>& progress = {}) {
  WAYFARE_EXPECTS(!plan.durations.empty() && !plan.satellites_left.empty() && !plan.places.empty(),
                  "outages need a duration, a number of satellites and a place");
  const std::size_t places = plan.places.size(), runs = places * plan.satellites_left.size();
  std::vector<std::optional<Result<OutageCourse>>> courses(runs);
  const auto one = [&](std::size_t i) {
    const LogTime begin = plan.places[i % places];
    courses[i] = detail::one_outage(
        plan, {begin, begin + plan.durations.back(), plan.satellites_left[i / places]}, run, truth);
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
                              detail::mean_over_places(report, s * places, places, d)});
  return report;
}

}  // namespace wayfare
