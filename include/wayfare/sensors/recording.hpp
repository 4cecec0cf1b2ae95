#pragma once

#include <vector>

#include <wayfare/sensors/laser_scan.hpp>
#include <wayfare/sensors/radar_scan.hpp>
#include <wayfare/sensors/trajectory.hpp>
#include <wayfare/sensors/wheels.hpp>

namespace wayfare {

/// A robot's recorded run in memory, independent of the file format. Each stream is in order of
/// time and may be empty.
struct Recording {
  Transform2<frame::Base, frame::Laser> T_base_laser = {};
  std::vector<LaserScan> scans = {};
  std::vector<OdometrySample> odometry = {};

  Transform2<frame::Base, frame::Radar> T_base_radar = {};
  /// Radial speeds wrap beyond ± this; 0: unknown.
  double radar_max_speed_m_s = 0.0;
  std::vector<RadarScan> radar = {};
  double wheel_base_m = 0.0;  ///< distance between the wheels; 0: unknown
  std::vector<WheelSample> wheels = {};
  std::vector<GyroSample> gyro = {};
  Trajectory truth = {};  ///< ground truth, e.g. of a simulator
};

}  // namespace wayfare
