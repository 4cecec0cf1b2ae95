#pragma once

// Standard deviation of a motion between two scans.

#include <cmath>

#include <Eigen/Core>

#include <wayfare/core/angle.hpp>
#include <wayfare/core/se2.hpp>

namespace wayfare {

/// Standard deviation of the motion between two scans, growing with the motion. Larger values widen
/// the search and reduce the weight of odometry where the scene is ambiguous.
struct MotionNoise {
  double translation_floor_m = 0.03;          ///< m, of a robot at rest
  double translation_per_m = 0.25;            ///< m along and across per metre moved
  double translation_per_rad_m = 0.02;        ///< m along and across per radian turned
  Angle heading_floor = Angle::degrees(1.5);  ///< of a robot at rest
  double heading_per_rad = 0.2;               ///< rad per radian turned
  double heading_per_m_rad = 0.1;             ///< rad per metre moved
};

/// Of (x, y, θ) after the motion `increment`, in the axes of the final pose.
[[nodiscard]] inline Eigen::Vector3d sigma_of(const SE2d& increment, const MotionNoise& noise) {
  const double d = increment.translation().norm();
  const double turn = std::abs(increment.heading().radians());
  const double along =
      noise.translation_floor_m + noise.translation_per_m * d + noise.translation_per_rad_m * turn;
  const double heading =
      noise.heading_floor.radians() + noise.heading_per_rad * turn + noise.heading_per_m_rad * d;
  return {along, along, heading};
}

}  // namespace wayfare
