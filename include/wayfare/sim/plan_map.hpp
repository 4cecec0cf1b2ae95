#pragma once

// The map a perfect mapper would draw of a floor plan.

#include <Eigen/Core>

#include <wayfare/core/result.hpp>
#include <wayfare/map/occupancy_grid.hpp>
#include <wayfare/sim/floor_plan.hpp>

namespace wayfare::sim {

/// Cells a wall passes through are occupied, those that can be reached from `inside_m` without
/// crossing one are free, the rest unknown. Fails where the plan has more cells than memory should
/// hold, and where `inside_m` is in a wall or outside.
[[nodiscard]] Result<OccupancyGrid> map_of_plan(const FloorPlan& plan,
                                                const Eigen::Vector2d& inside_m,
                                                const OccupancyGridOptions& options = {});

}  // namespace wayfare::sim
