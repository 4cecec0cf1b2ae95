#pragma once

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

#include <wayfare/core/so3.hpp>

namespace wayfare {

/// Rz(yaw) Ry(pitch) Rx(roll), radians; for `q_nb` the vehicle's attitude angles.
[[nodiscard]] inline SO3d rotation_from_roll_pitch_yaw(const Eigen::Vector3d& roll_pitch_yaw_rad) {
  using Eigen::AngleAxisd, Eigen::Vector3d;
  return SO3d(Eigen::Quaterniond(AngleAxisd(roll_pitch_yaw_rad[2], Vector3d::UnitZ()) *
                                 AngleAxisd(roll_pitch_yaw_rad[1], Vector3d::UnitY()) *
                                 AngleAxisd(roll_pitch_yaw_rad[0], Vector3d::UnitX())));
}

/// Roll and yaw in [−π, π], pitch in [−π/2, π/2]. At pitch ±π/2, where roll and yaw rotate about
/// the same axis, their split is arbitrary.
[[nodiscard]] inline Eigen::Vector3d roll_pitch_yaw_rad(const SO3d& rotation) {
  const Eigen::Matrix3d r = rotation.matrix();
  return {std::atan2(r(2, 1), r(2, 2)), std::asin(std::clamp(-r(2, 0), -1.0, 1.0)),
          std::atan2(r(1, 0), r(0, 0))};
}

}  // namespace wayfare
