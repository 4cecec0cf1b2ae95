#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <vector>

#include <Eigen/Core>

#include <wayfare/map/inverse_lidar.hpp>
#include <wayfare/map/likelihood_field.hpp>
#include <wayfare/map/occupancy_grid.hpp>
#include <wayfare/slam/scan_outcome.hpp>

namespace wayfare::detail {

/// Share of the rays of scans that cross a wall of the map a metre or more before their ends.
[[nodiscard]] inline double crossing_share(std::span<const PlacedPoints> scans,
                                           const OccupancyGrid& walls,
                                           const Eigen::Vector2d& laser) {
  constexpr double kEnd_m = 1.0;
  const LogOdds wall = LogOdds::from_probability(0.8);
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
        if (walls.log_odds(cell_of(from + k * step, walls.resolution_m())) <= wall) continue;
        ++crossed;
        break;
      }
    }
  }
  return rays == 0 ? 0.0 : static_cast<double>(crossed) / static_cast<double>(rays);
}

/// Of scans in the order they were taken.
[[nodiscard]] inline WallCrossings wall_crossings(std::span<const PlacedPoints> scans,
                                                  const OccupancyGrid& walls,
                                                  const Eigen::Vector2d& laser) {
  constexpr std::size_t kStretch = 20;
  std::vector<double> shares;
  for (std::size_t i = 0; i < scans.size(); ++i)
    shares.push_back(crossing_share(scans.subspan(i, 1), walls, laser));
  WallCrossings result{crossing_share(scans, walls, laser), 0.0};
  const std::size_t stretch = std::min(kStretch, shares.size());
  for (std::size_t i = 0; stretch > 0 && i + stretch <= shares.size(); ++i) {
    double sum = 0.0;
    for (std::size_t k = i; k < i + stretch; ++k) sum += shares[k];
    result.worst_stretch = std::max(result.worst_stretch, sum / static_cast<double>(stretch));
  }
  return result;
}

}  // namespace wayfare::detail
