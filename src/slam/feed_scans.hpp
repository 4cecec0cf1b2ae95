#pragma once

#include <cstddef>
#include <string>

#include <wayfare/core/result.hpp>
#include <wayfare/measure/recording.hpp>
#include <wayfare/sync/odometry_track.hpp>
#include <wayfare/system/graph_slam.hpp>

namespace wayfare::detail {

/// Scans that were not taken, and why the first of them was not.
struct Refusals {
  std::size_t count = 0;
  std::string first;
};

/// Gives `slam` every scan with the odometry at its time, until the progress callback ends it. An
/// Error where none could be used.
template <class Slam>
Result<Refusals> feed_scans(Slam& slam, const Recording& recording, const SlamProgress& progress) {
  const OdometryTrack odometry(recording.odometry);
  Refusals refused;
  for (std::size_t i = 0; i < recording.scans.size(); ++i) {
    const LaserScan& scan = recording.scans[i];
    const auto outcome = slam.add_scan(scan, odometry.at(scan.time));
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

}  // namespace wayfare::detail
