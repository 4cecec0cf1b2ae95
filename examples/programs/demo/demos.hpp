#pragma once

#include <wayfare/core/result.hpp>

#include "support/slam_program.hpp"

namespace wayfare::examples {

/// A robot with radar and LiDAR round a loop of corridors: odometry, graph SLAM and particle
/// filters beside each other.
[[nodiscard]] Result<void> run_corridors(const SlamArguments& arguments);

/// A robot with LiDAR twice through an office floor: graph SLAM.
[[nodiscard]] Result<void> run_office(const SlamArguments& arguments);

}  // namespace wayfare::examples
