#include <algorithm>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include <wayfare/nav/gnss_ins.hpp>

namespace wayfare {
namespace {

/// Feeds a recording to a filter in order of arrival.
struct Replay {
  const GnssInsRecording& recording;
  GnssIns filter;
  Duration imu_offset;
  GnssInsResult result = {};
  std::size_t ranges = 0, fixes = 0;

  void step(const ImuSample& s) {
    feed(recording.ranges, ranges, s.time + imu_offset);
    feed(recording.fixes, fixes, s.time + imu_offset);
    const bool used = report(s.time + imu_offset, filter.add(s));
    if (used && filter.started()) result.points.push_back(filter.point());
  }

  GnssInsResult finish() {
    result.innovations = filter.take_innovations();
    for (GnssInsNotice& n : filter.take_notices()) result.notices.push_back(std::move(n));
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

Result<GnssInsResult> run_once(const GnssInsRecording& recording, const GnssInsOptions& options,
                               const GnssInsProgress& progress, const std::stop_token& stop) {
  Replay replay{recording, GnssIns(options), from_seconds(options.imu_time_offset_s)};
  if (recording.start) replay.filter.start(*recording.start);
  const std::size_t n = recording.imu.size();
  for (std::size_t i = 0; i < n; ++i) {
    if (i % 1024 == 0) {
      if (stop.stop_requested()) return Error{ErrorCode::cancelled, "stopped on request"};
      if (progress) progress(static_cast<double>(i) / static_cast<double>(n));
    }
    replay.step(recording.imu[i]);
  }
  GnssInsResult result = replay.finish();
  if (progress) progress(1.0);
  if (result.points.empty())
    return Error{ErrorCode::degenerate,
                 "inertial navigation never started: " + replay.filter.missing()};
  return result;
}

}  // namespace

Result<GnssInsResult> run_gnss_ins(const GnssInsRecording& recording, const GnssInsOptions& options,
                                   const GnssInsProgress& progress, std::stop_token stop) {
  if (recording.imu.empty()) return Error{ErrorCode::invalid, "there are no inertial readings"};
  if (recording.ranges.empty() && recording.fixes.empty() && !recording.start)
    return Error{ErrorCode::invalid, "there are neither ranges nor fixes nor a start"};
  auto result = run_once(recording, options, progress, stop);
  if (result || result.error().code != ErrorCode::degenerate || options.start_without_velocity)
    return result;
  GnssInsOptions coarse = options;
  coarse.start_without_velocity = true;
  return run_once(recording, coarse, progress, stop);
}

}  // namespace wayfare
