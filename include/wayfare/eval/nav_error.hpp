#pragma once

// Error of a navigation solution.

#include <Eigen/Core>

#include <wayfare/sensors/nav_state.hpp>

namespace wayfare::eval {

/// Truth minus estimate.
struct NavError {
  Eigen::Vector3d position_ned_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d velocity_ned_mps = Eigen::Vector3d::Zero();
  Eigen::Vector3d attitude_body_rad = Eigen::Vector3d::Zero();  ///< rotation vector
};

[[nodiscard]] inline NavError nav_error(const NavState& estimate, const NavState& truth) {
  return {ned_from_geodetic(truth.position, estimate.position),
          truth.velocity_ned_mps - estimate.velocity_ned_mps, truth.q_nb.minus(estimate.q_nb)};
}

}  // namespace wayfare::eval
