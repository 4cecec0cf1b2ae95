#pragma once

#include <algorithm>
#include <cstddef>
#include <span>

#include <Eigen/Core>

#include <wayfare/map/inverse_lidar.hpp>
#include <wayfare/map/likelihood_field.hpp>
#include <wayfare/map/occupancy_grid.hpp>

namespace wayfare::detail {

/// Share of the rays of scans that cross a wall of the map a metre or more before their ends.
[[nodiscard]] inline double crossing_share(std::span<const PlacedPoints> scans,
                                           const OccupancyGrid& walls,
                                           const Eigen::Vector2d& laser) {
  constexpr double kEnd_m = 1.0, kWall = 0.8;
  const double step_m = 0.5 * walls.resolution_m();
  std::size_t crossed = 0, rays = 0;
  for (const PlacedPoints& scan : scans) {
    const Eigen::Vector2d from = scan.T_map_points * laser;
    rays += scan.points->size();
    for (std::size_t i = 0; i < scan.points->size(); ++i) {
      const Eigen::Vector2d end =
          scan.T_map_points * Eigen::Vector2d((*scan.points)[i].cast<double>());
      const int steps = static_cast<int>(((end - from).norm() - kEnd_m) / step_m);
      const Eigen::Vector2d step = (end - from).normalized() * step_m;
      for (int k = 0; k < steps; ++k) {
        if (!(walls.probability(cell_of(from + k * step, walls.resolution_m())) > kWall)) continue;
        ++crossed;
        break;
      }
    }
  }
  return rays == 0 ? 0.0 : static_cast<double>(crossed) / static_cast<double>(rays);
}

}  // namespace wayfare::detail
