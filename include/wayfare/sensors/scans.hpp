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
  LogTime time;         ///< of all beams; where they have times of their own, the middle of them
  Angle first_bearing;  ///< of beam 0
  Angle bearing_step;   ///< from beam to beam
  /// A range outside [min_range_m, max_range_m), or NaN, is a beam that did not return.
  float min_range_m = 0.0F;
  /// Beams at this range or beyond did not return.
  float max_range_m = 0.0F;
  std::vector<float> ranges_m;  ///< one for each beam
  /// From each beam to the next; negative where the laser turns clockwise, 0 where all are measured
  /// at `time`.
  Duration time_increment{0};
  /// Of each beam where they are not evenly spaced, as in a sweep after `deskew`; else empty.
  std::vector<Angle> bearings = {};

  /// Whether the beam has a range within the limits.
  [[nodiscard]] bool returned(std::size_t beam) const {
    const float r = ranges_m[beam];
    return r >= min_range_m && r < max_range_m;  // false for NaN
  }
  /// Direction of a beam in the laser's frame.
  [[nodiscard]] Angle bearing(std::size_t beam) const {
    return beam < bearings.size() ? bearings[beam]
                                  : first_bearing + bearing_step * static_cast<double>(beam);
  }
  /// Whether the beams have times of their own.
  [[nodiscard]] bool is_sweep() const {
    return time_increment != Duration::zero() && ranges_m.size() > 1;
  }
  /// From the first measured beam to the last, s; not negative.
  [[nodiscard]] double sweep_s() const {
    return is_sweep()
               ? std::abs(to_seconds(time_increment)) * static_cast<double>(ranges_m.size() - 1)
               : 0.0;
  }
  /// When the beam was measured.
  [[nodiscard]] LogTime beam_time(std::size_t beam) const {
    if (!is_sweep()) return time;
    const double from_middle =
        static_cast<double>(beam) - 0.5 * static_cast<double>(ranges_m.size() - 1);
    return time + from_seconds(from_middle * to_seconds(time_increment));
  }
  /// When the last measured beam was.
  [[nodiscard]] LogTime end_time() const { return time + from_seconds(0.5 * sweep_s()); }
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

namespace detail {

/// A level scan over the full circle, without points yet.
inline void begin_level_scan(const LaserScan& scan, const LevelScanOptions& options,
                             LaserScan& level) {
  constexpr double kTwoPi = 2.0 * std::numbers::pi;
  constexpr std::size_t kMaxBeams = 1'000'000;
  WAYFARE_EXPECTS(options.beams > 0 && options.beams <= kMaxBeams,
                  "a level scan has from 1 to a million beams");
  level.time = scan.time;
  level.first_bearing = Angle::radians(-std::numbers::pi);
  level.bearing_step = Angle::radians(kTwoPi / static_cast<double>(options.beams));
  level.min_range_m = scan.min_range_m;
  level.max_range_m = scan.max_range_m;
  level.ranges_m.assign(options.beams, std::numeric_limits<float>::quiet_NaN());
  level.time_increment = Duration::zero();
  level.bearings.clear();
}

/// Adds a point relative to the sensor, z up. The nearest point of each beam is kept.
inline void add_to_level_scan(const Eigen::Vector3d& p, const LevelScanOptions& options,
                              LaserScan& level) {
  if (!(p.z() >= options.lowest_m && p.z() <= options.highest_m)) return;
  const double beam_index =
      (std::atan2(p.y(), p.x()) + std::numbers::pi) / level.bearing_step.radians();
  float& range = level.ranges_m[static_cast<std::size_t>(std::lround(beam_index)) % options.beams];
  const auto projected = static_cast<float>(p.head<2>().norm());
  if (!(range <= projected)) range = projected;
}

/// The end of a beam in the laser's axes.
[[nodiscard]] inline Eigen::Vector3d beam_end(const LaserScan& scan, std::size_t beam) {
  const double bearing = scan.bearing(beam).radians();
  const Eigen::Vector3d direction(std::cos(bearing), std::sin(bearing), 0.0);
  return double(scan.ranges_m[beam]) * direction;
}

}  // namespace detail

/// The points of `scan` of a tilted range finder, on a carrier that sways (head, hand, small boat),
/// rotated by `q_level_laser` (z up) and projected onto the level plane, as a scan over the full
/// circle. The nearest point of each beam is used.
[[nodiscard]] inline LaserScan level_scan(const LaserScan& scan, const SO3d& q_level_laser,
                                          const LevelScanOptions& options = {}) {
  LaserScan level;
  detail::begin_level_scan(scan, options, level);
  for (std::size_t i = 0; i < scan.ranges_m.size(); ++i)
    if (scan.returned(i))
      detail::add_to_level_scan(q_level_laser * detail::beam_end(scan, i), options, level);
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
