#pragma once

// Private: a pose in space as text, `x y z qx qy qz qw`.

#include <cmath>
#include <optional>
#include <string>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <wayfare/core/se3.hpp>

#include "io/text/text.hpp"

namespace wayfare::io {

/// From seven numbers; nullopt where the quaternion is not of unit length, with a tolerance for
/// rounding of the text.
inline std::optional<SE3d> pose_of(const double* v) {
  const Eigen::Quaterniond q(v[6], v[3], v[4], v[5]);
  if (!(std::abs(q.norm() - 1.0) < 0.01)) return std::nullopt;
  return SE3d({v[0], v[1], v[2]}, SO3d(q));
}

inline void append_pose(std::string& out, const Eigen::Vector3d& t, const Eigen::Quaterniond& q) {
  text::append_numbers(out, {t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w()});
}

}  // namespace wayfare::io
