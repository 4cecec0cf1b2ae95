#pragma once

// Parameters, poses and report of pedestrian dead reckoning.

#include <cstdint>

#include <Eigen/Core>

#include <wayfare/core/angle.hpp>
#include <wayfare/inertial/ahrs_parameters.hpp>
#include <wayfare/inertial/attitude.hpp>
#include <wayfare/pedestrian/detail/magnetic_heading_drift.hpp>
#include <wayfare/pedestrian/detail/straight_walk.hpp>
#include <wayfare/pedestrian/step.hpp>
#include <wayfare/pedestrian/step_length.hpp>
#include <wayfare/sensors/trajectory.hpp>

namespace wayfare {

/// Source of the walking direction.
enum class WalkingAxis {
  sensor,     ///< an axis of the sensor, as held in the hand or worn on head, chest or hip
  principal,  ///< estimated from the body's sway: any mounting
};

/// For attitude indoors with a gyro whose bias was removed, as phones do: the field is disturbed
/// everywhere, so every reading is used with a low weight.
[[nodiscard]] inline AhrsParameters indoor_ahrs_parameters() {
  AhrsParameters p;
  p.bias_sigma *= 0.03;
  p.heading_density *= 2.0;
  p.field_norm_gate = 1.0;
  p.field_dip_gate = Angle::degrees(90.0);
  return p;
}

/// For a person known to walk, if only a few steps between pauses; all-day step counting requires
/// more in a row.
[[nodiscard]] inline StepParameters walking_step_parameters() {
  StepParameters p;
  p.least_steps = 4;
  return p;
}

struct PedestrianParameters {
  StepParameters steps = walking_step_parameters();
  StepLength length = KimStep{};
  AhrsParameters ahrs = indoor_ahrs_parameters();
  WalkingAxis axis = WalkingAxis::sensor;
  /// The sensor's axis along the walking direction; y on a phone.
  Eigen::Vector3d forward = Eigen::Vector3d::UnitY();
  /// Averaging time of the heading before a step, s: heads and hands turn to and fro.
  double heading_time_s = 0.5;
  /// Relative standard deviations of each step's length, and of the common scale.
  double length_sigma = 0.1;
  double length_scale_sigma = 0.06;
  /// Standard deviations of each step's direction, and of the common offset, rad; in addition to
  /// the attitude's.
  double direction_sigma = 0.1;
  double direction_offset_sigma = 0.15;
  /// Removes heading drift assuming straight segments. Helps on straight paths, harms on long
  /// bends; for units without magnetometer whose bias was not removed.
  StraightWalkParameters straight;
  /// Removes heading drift by an uncalibrated magnetometer; headings are then relative to the
  /// start.
  MagneticHeadingDriftParameters magnetic_drift;
};

/// Pose after a step. World axes: x east, y north with a magnetometer, else from the start.
struct PedestrianPose {
  LogTime time;
  Eigen::Vector2d position_m = Eigen::Vector2d::Zero();
  Angle heading;                                         ///< of walking, counter-clockwise from x
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< x, y in m, heading in rad
  Step step{};
  double length_m = 0.0;

  [[nodiscard]] OdometrySample odometry() const {
    return {time,
            Transform2<frame::Odom, frame::Base>(SE2d(position_m.x(), position_m.y(), heading))};
  }
};

struct PedestrianReport {
  AhrsReport ahrs;
  std::uint64_t steps = 0;
  std::uint64_t without_heading = 0;  ///< steps before the attitude was initialised
  double distance_m = 0.0;
};

}  // namespace wayfare
