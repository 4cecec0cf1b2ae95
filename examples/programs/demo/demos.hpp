#pragma once

#include <wayfare/core/result.hpp>

#include "support/slam_program.hpp"

namespace wayfare::examples {

/// A robot with radar and LiDAR in a loop of corridors: odometry, graph SLAM and particle filters.
[[nodiscard]] Result<void> run_corridors(const SlamArguments& arguments);

}  // namespace wayfare::examples
