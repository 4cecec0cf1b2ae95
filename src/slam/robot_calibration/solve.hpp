#pragma once

// The least-squares problem of a calibration: its graph, the noise of its sensors, and the joint
// covariance of all parameters.

#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include <Eigen/Core>

#include <wayfare/core/result.hpp>
#include <wayfare/slam/robot_calibration.hpp>

#include "slam/robot_calibration/edges.hpp"
#include "slam/robot_calibration/measurements.hpp"

namespace wayfare::calibration {

/// Values of all parameters.
struct Values {
  Wheels wheels = Wheels(1.0, 1.0, 1.0);
  SE2d laser, radar;
  GyroErrors gyro = GyroErrors(1.0, 0.0);
  double laser_delay_s = 0.0, radar_delay_s = 0.0, gyro_delay_s = 0.0;
};

/// Rows of the joint covariance: wheels, laser, its delay, radar, its delay, gyro, its delay; of
/// mountings right perturbations.
enum Row : Eigen::Index {
  kWheels = 0,
  kLaser = 3,
  kLaserDelay = 6,
  kRadar = 7,
  kRadarDelay = 10,
  kGyro = 11,
  kGyroDelay = 13,
  kRows = 14
};
using Joint = Eigen::Matrix<double, kRows, kRows>;

/// What is solved for.
struct Problem {
  const Measurements* measured = nullptr;
  BaseMotion base;
  Values start;
  bool laser = false, radar = false, gyro = false;  ///< sensors other than the base
};

struct Solution {
  Values values;
  Joint covariance;
  std::vector<CalibratedSensor> sensors;
};

/// Errors: those of the optimiser.
Result<Solution> solve(const Problem& problem, const RobotCalibrationOptions& options);

}  // namespace wayfare::calibration
