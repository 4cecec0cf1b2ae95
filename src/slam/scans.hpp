#pragma once

// What the systems that process scans share: checks of their input, and runs over a recording.

#include <cmath>
#include <cstddef>
#include <optional>
#include <string>

#include <wayfare/core/result.hpp>
#include <wayfare/sensors/recording.hpp>
#include <wayfare/slam/scan_outcome.hpp>
#include <wayfare/sync/odometry_track.hpp>

namespace wayfare {

class SubmapSlam;
struct SubmapSlamRun;

using MapPose = Transform2<frame::Map, frame::Base>;
using OdomPose = Transform2<frame::Odom, frame::Base>;

namespace detail {

inline std::optional<SE2d> raw(const std::optional<OdomPose>& odometry) {
  return odometry ? std::optional(odometry->raw()) : std::nullopt;
}

inline bool finite(Angle angle) { return std::isfinite(angle.radians()); }
inline bool finite(const SE2d& pose) {
  return pose.translation().allFinite() && finite(pose.heading());
}

/// Refuses a scan without beams or with geometry that is not finite.
inline Result<void> check_beams(const LaserScan& scan) {
  if (scan.ranges_m.empty()) return Error{ErrorCode::invalid, "the scan has no beams"};
  if (!finite(scan.first_bearing) || !finite(scan.bearing_step))
    return Error{ErrorCode::invalid, "the scan's bearings are not finite"};
  return {};
}

/// Also one with odometry that is not finite, or earlier than the last of `accepted`.
template <class Scans>
Result<void> check_scan(const LaserScan& scan, const std::optional<SE2d>& odometry,
                        const Scans& accepted) {
  if (auto ok = check_beams(scan); !ok) return ok;
  if (!accepted.empty() && scan.time < accepted.back().time)
    return Error{ErrorCode::invalid, "the scan is earlier than the one before it"};
  if (odometry && !finite(*odometry))
    return Error{ErrorCode::invalid, "the odometry pose is not finite"};
  return {};
}

/// Number of scans refused, and the reason for the first.
struct Refusals {
  std::size_t count = 0;
  std::string first = {};

  template <class T>
  void add(const Result<T>& outcome, const std::string& scan) {
    if (!outcome && count++ == 0) first = scan + ": " + outcome.error().message;
  }
};

/// Calls `add(i)` for every scan until the progress callback returns false. Returns an Error if
/// `statistics` then count no scan.
template <class Add, class Statistics>
Result<Refusals> feed_scans(const Recording& recording, const SlamProgress& progress,
                            const Statistics& statistics, const Add& add) {
  Refusals refused;
  const std::size_t n = recording.scans.size();
  for (std::size_t i = 0; i < n; ++i) {
    refused.add(add(i), "scan " + std::to_string(i));
    if (progress && !progress(static_cast<double>(i + 1) / static_cast<double>(n))) break;
  }
  if (statistics.scans > 0) return refused;
  return Error{ErrorCode::invalid,
               n == 0 ? "the recording has no scans" : "no scan could be used; " + refused.first};
}

/// Ends a run of submap SLAM over a recording.
Result<SubmapSlamRun> finished_run(SubmapSlam& slam, Refusals refused);

}  // namespace detail
}  // namespace wayfare
