#pragma once

#include <cstddef>
#include <string>

#include <wayfare/core/result.hpp>
#include <wayfare/sensors/recording.hpp>
#include <wayfare/slam/scan_outcome.hpp>
#include <wayfare/sync/odometry_track.hpp>

namespace wayfare::detail {

/// Number of scans refused, and the reason for the first.
struct Refusals {
  std::size_t count = 0;
  std::string first;
};

/// Passes every scan to `slam` with the motion `motion_at(i)` up to it, until the progress callback
/// returns false. Returns an Error if no scan could be used.
template <class Slam, class MotionAt>
Result<Refusals> feed_scans(Slam& slam, const Recording& recording, const SlamProgress& progress,
                            const MotionAt& motion_at) {
  Refusals refused;
  for (std::size_t i = 0; i < recording.scans.size(); ++i) {
    const auto outcome = slam.add_scan(recording.scans[i], motion_at(i));
    if (!outcome && refused.count++ == 0)
      refused.first = "scan " + std::to_string(i) + ": " + outcome.error().message;
    const double done = static_cast<double>(i + 1) / static_cast<double>(recording.scans.size());
    if (progress && !progress(done)) break;
  }
  if (slam.statistics().scans > 0) return refused;
  return Error{ErrorCode::invalid, recording.scans.empty()
                                       ? "the recording has no scans"
                                       : "no scan could be used; " + refused.first};
}

/// The same with odometry at the scans' times.
template <class Slam>
Result<Refusals> feed_scans(Slam& slam, const Recording& recording, const SlamProgress& progress) {
  const OdometryTrack odometry(recording.odometry);
  return feed_scans(slam, recording, progress,
                    [&](std::size_t i) { return odometry.at(recording.scans[i].time); });
}

}  // namespace wayfare::detail
