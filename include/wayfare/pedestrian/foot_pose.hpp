#pragma once

// What the foot tracker hands out.

#include <cstdint>

#include <Eigen/Core>

#include <wayfare/core/angle.hpp>
#include <wayfare/core/so3.hpp>
#include <wayfare/inertial/ahrs_report.hpp>
#include <wayfare/sensors/recording.hpp>

namespace wayfare {

/// The foot at one reading. World axes: z up, origin where it began, x and y as the sensor stood.
struct FootPose {
  LogTime time;
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d velocity_mps = Eigen::Vector3d::Zero();
  SO3d q_world_foot;
  Eigen::Matrix3d position_covariance_m2 = Eigen::Matrix3d::Zero();
  Angle heading;           ///< turned since the start, about the vertical, counter-clockwise
  double statistic = 0.0;  ///< of standing, by FootParameters::statistic
  double stands = 0.0;     ///< probability given to a stance found here; zero in between

  [[nodiscard]] OdometrySample odometry() const {
    return {time,
            Transform2<frame::Odom, frame::Base>(SE2d(position_m.x(), position_m.y(), heading))};
  }
};

/// What became of the readings, and what went wrong on the way.
struct FootReport {
  SensorReport gyro, accelerometer;
  std::uint64_t stances = 0;  ///< believed more than not
  std::uint64_t doubted = 0;  ///< quiet, but against the filter's own velocity
  std::uint64_t gaps = 0;     ///< pauses that left the velocity unknown
  std::uint64_t lost = 0;     ///< times velocity or attitude was taken anew
};

}  // namespace wayfare
