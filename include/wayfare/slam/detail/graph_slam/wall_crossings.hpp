#pragma once

#include <algorithm>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include <wayfare/map/inverse_lidar.hpp>
#include <wayfare/map/likelihood_field.hpp>
#include <wayfare/map/occupancy_grid.hpp>
#include <wayfare/slam/scan_outcome.hpp>

namespace wayfare::detail {

/// Rays of scans, and those that cross a wall of the map a metre or more before their ends.
struct CountedRays {
  std::size_t crossing = 0, all = 0;

  [[nodiscard]] double share() const {
    return all == 0 ? 0.0 : static_cast<double>(crossing) / static_cast<double>(all);
  }
  CountedRays& operator+=(const CountedRays& o) {
    crossing += o.crossing;
    all += o.all;
    return *this;
  }
};

[[nodiscard]] inline CountedRays crossing_rays(const PlacedPoints& scan, const OccupancyGrid& walls,
                                               const Eigen::Vector2d& laser) {
  using Tiles = OccupancyGrid::Tiles;
  constexpr double kEnd_m = 1.0;
  const LogOdds wall = LogOdds::from_probability(0.8);  // above that of unknown cells
  const double step_m = 0.5 * walls.resolution_m();
  const Eigen::Vector2d from = scan.T_map_points * laser;
  std::optional<Cell> at;  // a tile, looked up once for all steps within
  const Tiles::Tile* tile = nullptr;
  const auto is_wall = [&](const Cell& c) {
    if (Tiles::tile_of(c) != at) tile = walls.tiles().find(*(at = Tiles::tile_of(c)));
    return tile != nullptr && (*tile)[Tiles::offset_in_tile(c)] > wall.fixed;
  };
  CountedRays rays{0, scan.points->size()};
  for (std::size_t i = 0; i < scan.points->size(); ++i) {
    const Eigen::Vector2d ray =
        scan.T_map_points * Eigen::Vector2d((*scan.points)[i].cast<double>()) - from;
    const int steps = static_cast<int>((ray.norm() - kEnd_m) / step_m);
    const Eigen::Vector2d step = ray.normalized() * step_m;
    for (int k = 0; k < steps; ++k) {
      if (!is_wall(cell_of(from + k * step, walls.resolution_m()))) continue;
      ++rays.crossing;
      break;
    }
  }
  return rays;
}

[[nodiscard]] inline double crossing_share(std::span<const PlacedPoints> scans,
                                           const OccupancyGrid& walls,
                                           const Eigen::Vector2d& laser) {
  CountedRays sum;
  for (const PlacedPoints& scan : scans) sum += crossing_rays(scan, walls, laser);
  return sum.share();
}

/// Of scans in the order they were taken.
[[nodiscard]] inline WallCrossings wall_crossings(std::span<const PlacedPoints> scans,
                                                  const OccupancyGrid& walls,
                                                  const Eigen::Vector2d& laser) {
  constexpr std::size_t kStretch = 20;
  CountedRays all;
  std::vector<double> shares;
  for (const PlacedPoints& scan : scans) {
    const CountedRays rays = crossing_rays(scan, walls, laser);
    all += rays;
    shares.push_back(rays.share());
  }
  WallCrossings result{all.share(), 0.0};
  const std::size_t stretch = std::min(kStretch, shares.size());
  for (std::size_t i = 0; stretch > 0 && i + stretch <= shares.size(); ++i) {
    double sum = 0.0;
    for (std::size_t k = i; k < i + stretch; ++k) sum += shares[k];
    result.worst_stretch = std::max(result.worst_stretch, sum / static_cast<double>(stretch));
  }
  return result;
}

}  // namespace wayfare::detail
