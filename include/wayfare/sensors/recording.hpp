#pragma once

// A robot's recorded run, and thinning of its scans.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include <wayfare/sensors/measurements.hpp>
#include <wayfare/sensors/scans.hpp>
#include <wayfare/sensors/trajectory.hpp>

namespace wayfare {

/// A robot's recorded run in memory, independent of the file format. Each stream is in order of
/// time and may be empty.
struct Recording {
  Transform2<frame::Base, frame::Laser> T_base_laser = {};  ///< mounting of the laser
  std::vector<LaserScan> scans = {};                        ///< of the laser
  std::vector<OdometrySample> odometry = {};                ///< poses by dead reckoning

  Transform2<frame::Base, frame::Radar> T_base_radar = {};  ///< mounting of the radar
  /// Radial speeds wrap beyond ± this; 0: unknown.
  double radar_max_speed_m_s = 0.0;
  std::vector<RadarScan> radar = {};     ///< frames of the radar
  double wheel_base_m = 0.0;             ///< distance between the wheels; 0: unknown
  std::vector<WheelSample> wheels = {};  ///< distances of the wheels
  std::vector<GyroSample> gyro = {};     ///< mean turn rates
  Trajectory truth = {};                 ///< ground truth, e.g. of a simulator
};

/// A recording as a lesser sensor would have made it. 0 scans or beams count as 1.
struct Thinning {
  std::size_t every = 1;           ///< keeps each every-th scan …
  std::size_t beams = 1;           ///< … and each beams-th beam of it
  double max_range_m = 0.0;        ///< farther ranges become missing returns; 0: no limit
  double field_of_view_deg = 0.0;  ///< of the beams kept, symmetric about ahead; 0: all
};

/// Thins one scan, whatever Thinning::every.
inline void thin(LaserScan& scan, const Thinning& t) {
  const std::size_t every_beam = std::max<std::size_t>(t.beams, 1);
  const double half = Angle::degrees(0.5 * t.field_of_view_deg).radians();
  std::vector<float> kept;
  std::vector<Angle> bearings;
  std::size_t first = scan.ranges_m.size(), last = first;
  for (std::size_t i = 0; i < scan.ranges_m.size(); ++i) {
    if (t.field_of_view_deg > 0 && std::abs(scan.bearing(i).radians()) > half) continue;
    first = std::min(first, i);
    if ((i - first) % every_beam != 0) continue;
    kept.push_back(scan.ranges_m[i]);
    if (!scan.bearings.empty()) bearings.push_back(scan.bearing(i));
    last = i;
  }
  if (!kept.empty()) scan.first_bearing = scan.bearing(first);
  if (scan.is_sweep() && !kept.empty()) {
    const double middle = 0.5 * (static_cast<double>(first) + static_cast<double>(last) -
                                 static_cast<double>(scan.ranges_m.size() - 1));
    const double beam_s = to_seconds(scan.time_increment);
    scan.time += from_seconds(middle * beam_s);
    scan.time_increment = from_seconds(static_cast<double>(every_beam) * beam_s);
  }
  scan.bearings = std::move(bearings);
  scan.bearing_step = scan.bearing_step * static_cast<double>(every_beam);
  scan.ranges_m = std::move(kept);
  if (t.max_range_m > 0)
    scan.max_range_m = std::min(scan.max_range_m, static_cast<float>(t.max_range_m));
}

/// Thins the scans; other streams are unchanged.
inline void thin(Recording& recording, const Thinning& t) {
  std::vector<LaserScan> kept;
  const std::size_t every = std::max<std::size_t>(t.every, 1);
  for (std::size_t i = 0; i < recording.scans.size();) {
    thin(recording.scans[i], t);
    kept.push_back(std::move(recording.scans[i]));
    if (every >= recording.scans.size() - i) break;
    i += every;
  }
  recording.scans = std::move(kept);
}

}  // namespace wayfare
