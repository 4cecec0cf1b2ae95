#pragma once

// The ideal map of a floor plan.

#include <Eigen/Core>

#include <wayfare/core/result.hpp>
#include <wayfare/map/occupancy_grid.hpp>
#include <wayfare/sim/floor_plan.hpp>

namespace wayfare::sim {

/// Cells that a wall passes through are occupied, those that can be reached from `inside_m` without
/// crossing one are free, the rest unknown. Errors: more cells than fit in memory, or an `inside_m`
/// in a wall or outside.
[[nodiscard]] Result<OccupancyGrid> map_of_plan(const FloorPlan& plan,
                                                const Eigen::Vector2d& inside_m,
                                                const OccupancyGridOptions& options = {});

}  // namespace wayfare::sim
