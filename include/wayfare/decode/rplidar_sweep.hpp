#pragma once

// Revolutions of an RPLIDAR as scans with the times of their beams.

#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

#include <wayfare/core/time.hpp>
#include <wayfare/decode/rplidar_scan.hpp>
#include <wayfare/sensors/scans.hpp>

namespace wayfare::decode {

/// As `to_laser_scan`, with the times of the beams: evenly spaced bearings up to 0, ahead, where a
/// revolution begins and ends. The laser turns clockwise: the last beam is measured first. The
/// scan's time is that of its middle, by the times and angles of the first and the last point;
/// where these are no quarter of a turn apart, all beams are of the first point's. `qualities`, if
/// given, becomes the quality of each beam's point, 0 without one.
[[nodiscard]] inline LaserScan to_laser_sweep(const RplidarRevolution& revolution,
                                              const RplidarScanOptions& options = {},
                                              std::vector<float>* qualities = nullptr) {
  LaserScan scan;
  if (qualities != nullptr) qualities->assign(options.beams, 0.0F);
  scan.min_range_m = options.min_range_m;
  scan.max_range_m = options.max_range_m;
  if (options.beams == 0 || revolution.points.empty()) return scan;
  const auto last = static_cast<double>(options.beams - 1);
  const double step_deg = 360.0 / static_cast<double>(options.beams);
  const std::size_t n = revolution.points.size();
  scan.first_bearing = Angle::degrees(-step_deg * last);
  scan.bearing_step = Angle::degrees(step_deg);
  scan.ranges_m.assign(options.beams, std::numeric_limits<float>::quiet_NaN());
  // Near its ends a revolution may begin before 0 degrees and end after 360.
  const auto turned_deg = [&](std::size_t i) {
    const double angle = revolution.points[i].point.angle_deg();
    if (2 * i < n) return angle > 270.0 ? angle - 360.0 : angle;
    return angle < 90.0 && n > 1 ? angle + 360.0 : angle;
  };
  for (std::size_t i = 0; i < n; ++i) {
    const RplidarPoint& point = revolution.points[i].point;
    const auto range = static_cast<float>(point.distance_m());
    const double beam = last - std::round(turned_deg(i) / step_deg);
    if (point.distance_q2 == 0 || !(range >= options.min_range_m && range < options.max_range_m) ||
        !(beam >= 0.0 && beam <= last))
      continue;
    float& kept = scan.ranges_m[static_cast<std::size_t>(beam)];
    if (kept <= range) continue;
    kept = range;
    if (qualities != nullptr) (*qualities)[static_cast<std::size_t>(beam)] = point.quality;
  }
  scan.time = revolution.points.front().time;
  const double first_deg = turned_deg(0), span_deg = turned_deg(n - 1) - first_deg;
  if (!(span_deg > 90.0)) return scan;
  const double s_per_deg = to_seconds(revolution.points.back().time - scan.time) / span_deg;
  scan.time += from_seconds(s_per_deg * (0.5 * step_deg * last - first_deg));
  scan.time_increment = from_seconds(-s_per_deg * step_deg);
  return scan;
}

}  // namespace wayfare::decode
