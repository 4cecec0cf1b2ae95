#pragma once

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

#include <wayfare/nav/gnss_ins.hpp>

namespace wayfare::nav {

/// Feeds a recording to a filter in order of arrival.
struct Replay {
  const GnssInsRecording& recording;
  GnssIns filter;
  Duration imu_offset;
  GnssInsResult result = {};
  std::size_t ranges = 0, fixes = 0, wheels = 0;

  void step(const ImuSample& s) {
    feed(recording.ranges, ranges, s.time + imu_offset);
    feed(recording.fixes, fixes, s.time + imu_offset);
    feed(recording.wheels, wheels, s.time + imu_offset);
    const bool used = report(s.time + imu_offset, filter.add(s));
    if (used && filter.started()) result.points.push_back(filter.point());
  }

  /// Takes what happened from the filter.
  void collect() {
    for (const InnovationRecord& i : filter.take_innovations()) result.innovations.push_back(i);
    for (GnssInsNotice& n : filter.take_notices()) result.notices.push_back(std::move(n));
  }

  GnssInsResult finish() {
    collect();
    std::stable_sort(result.notices.begin(), result.notices.end(),
                     [](const auto& a, const auto& b) { return a.time < b.time; });
    return std::move(result);
  }

 private:
  template <class Gnss>
  void feed(const std::vector<Gnss>& all, std::size_t& next, LogTime until) {
    for (; next < all.size() && all[next].time <= until; ++next)
      report(all[next].time, filter.add(all[next]));
  }
  bool report(LogTime time, const Result<void>& r) {
    if (!r) result.notices.push_back({time, r.error().message});
    return r.has_value();
  }
};

inline Error never_started(const GnssIns& filter) {
  return {ErrorCode::degenerate, "inertial navigation never started: " + filter.missing()};
}
inline Error stopped() { return {ErrorCode::cancelled, "stopped on request"}; }

/// What `run` gives; where nothing started, also without velocities. Fails for recordings of which
/// nothing can come.
template <class Run>
Result<GnssInsResult> with_coarse_start(const GnssInsRecording& recording,
                                        const GnssInsOptions& options, const Run& run) {
  if (recording.imu.empty()) return Error{ErrorCode::invalid, "there are no inertial readings"};
  if (recording.ranges.empty() && recording.fixes.empty() && !recording.start)
    return Error{ErrorCode::invalid, "there are neither ranges nor fixes nor a start"};
  const CorrelatedErrorOptions& c = options.correlated;
  if (!(c.share >= 0.0 && c.share <= 1.0 && c.tau_s > 0.0 && c.distance_m > 0.0))
    return Error{ErrorCode::invalid,
                 "correlated errors need a share within [0, 1], and a positive time and distance"};
  if (!(options.robust_sigma >= 0.0))
    return Error{ErrorCode::invalid, "robust_sigma must not be negative"};
  auto result = run(options);
  if (result || result.error().code != ErrorCode::degenerate || options.start_without_velocity)
    return result;
  GnssInsOptions coarse = options;
  coarse.start_without_velocity = true;
  return run(coarse);
}

}  // namespace wayfare::nav
