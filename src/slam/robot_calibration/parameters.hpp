#pragma once

#include <wayfare/sensors/recording.hpp>
#include <wayfare/slam/robot_calibration.hpp>

#include "slam/robot_calibration/solve.hpp"

namespace wayfare::calibration {

/// Parameters and covariance of the result.
void fill(RobotCalibration& result, const Problem& problem, const Solution& solution,
          const Recording& recording, const RobotCalibrationOptions& options);

}  // namespace wayfare::calibration
