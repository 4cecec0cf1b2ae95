#pragma once

// What a recording says of each sensor's motion, on seconds since its beginning.

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include <wayfare/core/result.hpp>
#include <wayfare/sensors/recording.hpp>
#include <wayfare/slam/robot_calibration.hpp>

#include "slam/robot_calibration/base_motion.hpp"
#include "slam/robot_calibration/laser_motions.hpp"
#include "slam/robot_calibration/start.hpp"

namespace wayfare::calibration {

/// Mean velocity of the radar over a few frames.
struct RadarMotion {
  double from_s = 0.0, to_s = 0.0;
  Eigen::Vector2d velocity_m_s;
  Eigen::Matrix2d covariance;
};

/// Angle that the gyro reports over an interval.
struct GyroTurned {
  double from_s = 0.0, to_s = 0.0, turn_rad = 0.0;
};

struct Measurements {
  std::vector<BaseStep> wheels;
  LaserMotions laser;
  std::vector<RadarMotion> radar;
  std::vector<GyroTurned> gyro;
  double doppler_step_m_s = 0.0;  ///< between the radar's bins; 0: its speeds are not rounded
  std::size_t radar_frames = 0, radar_without = 0;
  std::vector<std::string> notes;
};

/// Errors: cancelled by the progress callback.
Result<Measurements> measure(const Recording& recording, const RobotCalibrationOptions& options,
                             const SlamProgress& progress);

std::vector<SensorVelocity> velocities_of(const std::vector<LaserMotion>& motions);
std::vector<SensorVelocity> velocities_of(const std::vector<RadarMotion>& motions);

}  // namespace wayfare::calibration
