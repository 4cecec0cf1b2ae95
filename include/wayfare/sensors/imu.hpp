#pragma once

#include <Eigen/Core>

#include <wayfare/core/time.hpp>

namespace wayfare {

/// One reading of an inertial unit in its own axes. Specific force: what accelerometers measure, +g
/// upward at rest.
struct ImuSample {
  LogTime time;
  Eigen::Vector3d angular_rate_radps = Eigen::Vector3d::Zero();
  Eigen::Vector3d specific_force_mps2 = Eigen::Vector3d::Zero();
};

}  // namespace wayfare
