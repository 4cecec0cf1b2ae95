#pragma once

// Scans of lasers and radars, and levelled scans of a swaying laser.

#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>
#include <vector>

#include <Eigen/Core>

#include <wayfare/core/angle.hpp>
#include <wayfare/core/contract.hpp>
#include <wayfare/core/se3.hpp>
#include <wayfare/core/time.hpp>

namespace wayfare {

/// One sweep of a planar range finder. Beam i points along `first_bearing + i * bearing_step` in
/// the laser's frame (counter-clockwise positive, 0 along x).
struct LaserScan {
  LogTime time;         ///< of the first beam
  Angle first_bearing;  ///< of beam 0
  Angle bearing_step;   ///< from beam to beam
  /// A range outside [min_range_m, max_range_m), or NaN, is a beam that did not return.
  float min_range_m = 0.0F;
  /// Beams at this range or beyond did not return.
  float max_range_m = 0.0F;
  std::vector<float> ranges_m;  ///< one for each beam

  /// Whether the beam has a range within the limits.
  [[nodiscard]] bool returned(std::size_t beam) const {
    const float r = ranges_m[beam];
    return r >= min_range_m && r < max_range_m;  // false for NaN
  }
  /// Direction of a beam in the laser's frame.
  [[nodiscard]] Angle bearing(std::size_t beam) const {
    return first_bearing + bearing_step * static_cast<double>(beam);
  }
};

/// Heights and beams of level_scan.
struct LevelScanOptions {
  /// Lower and higher points, m above the sensor, are floor and ceiling and are dropped.
  double lowest_m = -1.2,  ///< m above the sensor
      highest_m = 0.8;     ///< m above the sensor
  /// Beams of the level scan over a full circle, from 1 to 10⁶; more represent the bearings more
  /// precisely.
  std::size_t beams = 3600;
};

/// The points of `scan` of a tilted range finder, on a carrier that sways (head, hand, small boat),
/// rotated by `q_level_laser` (z up) and projected onto the level plane, as a scan over the full
/// circle. The nearest point of each beam is used.
[[nodiscard]] inline LaserScan level_scan(const LaserScan& scan, const SO3d& q_level_laser,
                                          const LevelScanOptions& options = {}) {
  constexpr double kTwoPi = 2.0 * std::numbers::pi;
  constexpr std::size_t kMaxBeams = 1'000'000;
  WAYFARE_EXPECTS(options.beams > 0 && options.beams <= kMaxBeams,
                  "a level scan has from 1 to a million beams");
  const double step = kTwoPi / static_cast<double>(options.beams);
  LaserScan level{scan.time,
                  Angle::radians(-std::numbers::pi),
                  Angle::radians(step),
                  scan.min_range_m,
                  scan.max_range_m,
                  std::vector<float>(options.beams, std::numeric_limits<float>::quiet_NaN())};
  for (std::size_t i = 0; i < scan.ranges_m.size(); ++i) {
    if (!scan.returned(i)) continue;
    const double bearing = scan.bearing(i).radians();
    const Eigen::Vector3d beam(std::cos(bearing), std::sin(bearing), 0.0);
    const Eigen::Vector3d p = q_level_laser * Eigen::Vector3d(double(scan.ranges_m[i]) * beam);
    if (!(p.z() >= options.lowest_m && p.z() <= options.highest_m)) continue;
    const double beam_index = (std::atan2(p.y(), p.x()) + std::numbers::pi) / step;
    float& range =
        level.ranges_m[static_cast<std::size_t>(std::lround(beam_index)) % options.beams];
    const auto projected = static_cast<float>(p.head<2>().norm());
    if (!(range <= projected)) range = projected;
  }
  return level;
}

/// A reflection a millimetre-wave radar detected, in the radar's own frame: x forward, y left,
/// z up, metres.
struct RadarPoint {
  float x_m = 0.0F;          ///< forward
  float y_m = 0.0F;          ///< left
  float z_m = 0.0F;          ///< 0 where the radar does not measure elevation
  float doppler_m_s = 0.0F;  ///< radial speed, positive away from the radar
  float snr_db = 0.0F;       ///< signal over the noise of its range and Doppler cell

  /// Whether all values are equal.
  friend bool operator==(const RadarPoint&, const RadarPoint&) = default;
};

/// The detections of one radar frame; often none. Unlike a laser beam without a return, a direction
/// without a point carries no information about free space.
struct RadarScan {
  LogTime time;                         ///< of the frame
  std::vector<RadarPoint> points = {};  ///< in any order
};

}  // namespace wayfare
