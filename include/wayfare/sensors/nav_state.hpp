#pragma once

#include <vector>

#include <Eigen/Core>

#include <wayfare/core/frame.hpp>
#include <wayfare/core/geodesy.hpp>
#include <wayfare/core/se3.hpp>
#include <wayfare/core/time.hpp>

namespace wayfare {

/// Position, velocity and attitude of a vehicle, estimated or reference. `q_nb` rotates body
/// (forward-right-down) to local level (north-east-down).
struct NavState {
  LogTime time;
  Geodetic position;
  Eigen::Vector3d velocity_ned_mps = Eigen::Vector3d::Zero();
  SO3d q_nb;
};

using NavTrajectory = std::vector<NavState>;

}  // namespace wayfare
