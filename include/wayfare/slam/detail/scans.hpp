#pragma once

// What the systems that process scans share: checks of their input, and runs over a recording.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <initializer_list>
#include <optional>
#include <string>

#include <wayfare/core/result.hpp>
#include <wayfare/sensors/recording.hpp>
#include <wayfare/slam/scan_outcome.hpp>
#include <wayfare/sync/odometry_track.hpp>
#include <wayfare/sync/scan_deskewer.hpp>

namespace wayfare {

class SubmapSlamSystem;
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

/// Whether every beam has a bearing.
inline bool has_finite_bearings(const LaserScan& scan) {
  const bool of_each = scan.bearings.empty() ||
                       (scan.bearings.size() == scan.ranges_m.size() &&
                        std::ranges::all_of(scan.bearings, [](Angle b) { return finite(b); }));
  return of_each && finite(scan.first_bearing) && finite(scan.bearing_step) &&
         finite(scan.bearing(scan.ranges_m.size()));
}

/// Refuses a scan without beams or with geometry that is not finite.
inline Result<void> check_beams(const LaserScan& scan) {
  if (scan.ranges_m.empty()) return Error{ErrorCode::invalid, "the scan has no beams"};
  if (!has_finite_bearings(scan))
    return Error{ErrorCode::invalid, "the scan's bearings are not finite"};
  return {};
}

/// Also one earlier than the last of `accepted`, or with odometry that is not finite or so far away
/// that the cells of fine maps are not numbered there.
template <class Scans>
Result<void> check_scan(const LaserScan& scan, const std::optional<SE2d>& odometry,
                        const Scans& accepted) {
  constexpr double kFarthest_m = 1e7;  // also farther than the coordinates of any map projection
  if (auto ok = check_beams(scan); !ok) return ok;
  if (!accepted.empty() && scan.time < accepted.back().time)
    return Error{ErrorCode::invalid, "the scan is earlier than the one before it"};
  if (odometry && !finite(*odometry))
    return Error{ErrorCode::invalid, "the odometry pose is not finite"};
  if (odometry && odometry->translation().cwiseAbs().maxCoeff() > kFarthest_m)
    return Error{ErrorCode::invalid, "the odometry pose is farther than 10 000 km from its origin"};
  return {};
}

/// Limits counts among the options: from zero to a number that can be added to any index.
inline void limit_counts(std::initializer_list<int*> counts) {
  for (int* count : counts) *count = std::clamp(*count, 0, 1 << 28);
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

/// Gives scan i of a recording to `add`: a sweep as an instantaneous scan, by the recording's
/// odometry and gyro.
template <class Add>
Result<ScanOutcome> add_deskewed(ScanDeskewer& deskewer, const Recording& recording, std::size_t i,
                                 const Add& add) {
  const LaserScan& scan = recording.scans[i];
  if (!scan.is_sweep()) return add(scan);
  const auto instant = deskewer(scan, recording.odometry, recording.gyro);
  if (!instant) return instant.error();
  Result<ScanOutcome> outcome = add(**instant);
  if (outcome) deskewer.placed(scan.time, outcome->T_map_base.raw(), outcome->loop_closures > 0);
  return outcome;
}

/// Ends a run of submap SLAM over a recording.
Result<SubmapSlamRun> finished_run(SubmapSlamSystem& slam, Refusals refused);

}  // namespace detail
}  // namespace wayfare
