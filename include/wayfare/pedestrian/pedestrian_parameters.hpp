#pragma once

// What pedestrian dead reckoning hands out.

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

/// Where the direction of walking is taken from.
enum class WalkingAxis {
  sensor,     ///< an axis of the sensor, as held in the hand or worn on head, chest or hip
  principal,  ///< found from how the body sways: the sensor may sit any way round
};

/// For an attitude indoors, of a unit whose gyro bias was taken off before, as phones do: the field
/// is bent everywhere, so none of it is refused and each reading counts for little.
[[nodiscard]] inline AhrsParameters indoor_ahrs_parameters() {
  AhrsParameters p;
  p.bias_sigma *= 0.03;
  p.heading_density *= 2.0;
  p.field_norm_gate = 1.0;
  p.field_dip_gate = Angle::degrees(90.0);
  return p;
}

/// For who is known to walk, if only a few steps before the next pause; what counts steps all day
/// asks for more in a row.
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
  /// The sensor's axis that points where the body walks; y on a phone.
  Eigen::Vector3d forward = Eigen::Vector3d::UnitY();
  /// The heading is averaged for so long before a step, s: heads and hands turn to and fro.
  double heading_time_s = 0.5;
  /// What is unknown of the length of each step, and of all alike, as part of it.
  double length_sigma = 0.1;
  double length_scale_sigma = 0.06;
  /// What is unknown of the way each step goes, and of all alike, rad; beside the attitude's own.
  double direction_sigma = 0.1;
  double direction_offset_sigma = 0.15;
  /// Drift of the heading taken away by what ways have in common. Helps along straight pieces,
  /// harms on long bends; for units without a magnetometer whose bias nobody took off.
  StraightWalkParameters straight;
  /// Drift taken away by a magnetometer that was never calibrated; headings then count from the
  /// start, by gyro and accelerometer.
  MagneticHeadingDriftParameters magnetic_drift;
};

/// After a step. World axes: x east, y north where there is a magnetometer, else as at the start.
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
  std::uint64_t without_heading = 0;  ///< steps before there was an attitude
  double walked_m = 0.0;
};

}  // namespace wayfare
