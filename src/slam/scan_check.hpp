#pragma once

#include <cmath>
#include <optional>

#include <wayfare/core/result.hpp>
#include <wayfare/core/se2.hpp>
#include <wayfare/sensors/laser_scan.hpp>

namespace wayfare::detail {

/// Refuses a scan without beams, with geometry or odometry that is not finite, or earlier than the
/// previous one.
inline Result<void> check_scan(const LaserScan& scan, const std::optional<SE2d>& odometry,
                               const std::optional<LogTime>& last) {
  const auto is_finite = [](Angle angle) { return std::isfinite(angle.radians()); };
  const auto fault = [](const char* what) { return Error{ErrorCode::invalid, what}; };
  if (scan.ranges_m.empty()) return fault("the scan has no beams");
  if (!is_finite(scan.first_bearing) || !is_finite(scan.bearing_step))
    return fault("the scan's bearings are not finite");
  if (last && scan.time < *last) return fault("the scan is earlier than the one before it");
  if (odometry && !(odometry->translation().allFinite() && is_finite(odometry->heading())))
    return fault("the odometry pose is not finite");
  return {};
}

}  // namespace wayfare::detail
