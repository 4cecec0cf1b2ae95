#pragma once

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

#include <wayfare/core/so3.hpp>

namespace wayfare {

/// The rotation Rz(yaw) Ry(pitch) Rx(roll), radians: of `q_nb`, the attitude angles of a vehicle.
[[nodiscard]] inline SO3d rotation_from_roll_pitch_yaw(const Eigen::Vector3d& roll_pitch_yaw_rad) {
  using Eigen::AngleAxisd, Eigen::Vector3d;
  return SO3d(Eigen::Quaterniond(AngleAxisd(roll_pitch_yaw_rad[2], Vector3d::UnitZ()) *
                                 AngleAxisd(roll_pitch_yaw_rad[1], Vector3d::UnitY()) *
                                 AngleAxisd(roll_pitch_yaw_rad[0], Vector3d::UnitX())));
}

/// Roll and yaw in [−π, π], pitch in [−π/2, π/2]. Straight up or down, where roll and yaw turn
/// about one axis, any split of their sum.
[[nodiscard]] inline Eigen::Vector3d roll_pitch_yaw_rad(const SO3d& rotation) {
  const Eigen::Matrix3d r = rotation.matrix();
  return {std::atan2(r(2, 1), r(2, 2)), std::asin(std::clamp(-r(2, 0), -1.0, 1.0)),
          std::atan2(r(1, 0), r(0, 0))};
}

}  // namespace wayfare
