#pragma once

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
/// the same axis, only yaw − roll (up) or yaw + roll (down) is determined: roll is then 0 by
/// convention. At any pitch `rotation_from_roll_pitch_yaw` of the angles is the rotation, within
/// rounding.
[[nodiscard]] inline Eigen::Vector3d roll_pitch_yaw_rad(const SO3d& rotation) {
  constexpr double kStraight = 1e-12;  // cosine of a pitch at which roll would be rounding
  const Eigen::Matrix3d r = rotation.matrix();
  const double cos_pitch = std::hypot(r(2, 1), r(2, 2));
  const double roll = cos_pitch < kStraight ? 0.0 : std::atan2(r(2, 1), r(2, 2));
  // From the rotation without the roll: near pitch ±π/2 its second column determines yaw better
  // than its first.
  const double s = std::sin(roll), c = std::cos(roll);
  const double yaw = std::atan2(s * r(0, 2) - c * r(0, 1), c * r(1, 1) - s * r(1, 2));
  return {roll, std::atan2(-r(2, 0), cos_pitch), yaw};
}

}  // namespace wayfare
