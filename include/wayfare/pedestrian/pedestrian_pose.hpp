#pragma once

// What pedestrian dead reckoning hands out.

#include <cstdint>

#include <Eigen/Core>

#include <wayfare/core/angle.hpp>
#include <wayfare/inertial/ahrs_report.hpp>
#include <wayfare/pedestrian/step.hpp>
#include <wayfare/sensors/recording.hpp>

namespace wayfare {

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
