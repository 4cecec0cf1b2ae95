#pragma once

#include <cmath>
#include <optional>
#include <string_view>

#include <wayfare/core/se3.hpp>
#include <wayfare/ros/messages.hpp>

// What conversions and recordings take from transforms of messages.

namespace wayfare::ros {

/// Frames' names of ROS 1 may begin with a slash.
inline std::string_view without_slash(std::string_view name) {
  if (name.starts_with('/')) name.remove_prefix(1);
  return name;
}

/// Whether the norm is 1 within 0.5 %; false for NaN.
inline bool is_unit(const Quaternion& q) {
  return std::abs(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w - 1.0) < 1e-2;
}

/// Nothing where a number is not finite or the rotation not of unit norm.
inline std::optional<SE3d> rigid(const TransformParts& t) {
  const Eigen::Quaterniond q(t.rotation.w, t.rotation.x, t.rotation.y, t.rotation.z);
  const Eigen::Vector3d at(t.translation.x, t.translation.y, t.translation.z);
  if (!at.allFinite() || !is_unit(t.rotation)) return std::nullopt;
  return SE3d(at, SO3d(q));
}

}  // namespace wayfare::ros
