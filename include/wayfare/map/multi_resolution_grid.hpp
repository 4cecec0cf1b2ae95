#pragma once

#include <cstddef>
#include <vector>

#include <wayfare/map/detail/scan_raster.hpp>
#include <wayfare/map/inverse_lidar.hpp>
#include <wayfare/map/occupancy_grid.hpp>
#include <wayfare/map/probability_grid.hpp>

namespace wayfare {

struct MultiResolutionOptions {
  OccupancyGridOptions finest{};
  int levels = 3;  ///< each with cells twice as wide as the next
  InverseLidarModel model{.p_free = 0.4, .p_hit = 0.9};
  double unknown_probability = 0.5;  ///< what a scan point is worth where nobody looked yet
};

/// Occupancy at several resolutions, every scan put into all of them (Kohlbrecher et al. 2011), and
/// beside them the tables that matchers climb.
class MultiResolutionGrid {
 public:
  explicit MultiResolutionGrid(const MultiResolutionOptions& options = {});

  /// Puts a scan into every grid, and the tables up to date. Refused as by `insert_scan`, or where
  /// a table would grow too large; then nothing has changed.
  Result<void> insert(const SE2d& T_map_laser, const LaserScan& scan);
  /// The same for end points of rays that begin at `origin`, as `insert_points` takes them.
  Result<void> insert(const SE2d& T_map_points, const PointSet& points,
                      const Eigen::Vector2d& origin = Eigen::Vector2d::Zero());

  [[nodiscard]] bool empty() const { return tables_.empty(); }
  [[nodiscard]] const OccupancyGrid& finest() const { return grids_.back(); }
  /// Coarse to fine; empty before the first scan.
  [[nodiscard]] const ProbabilityPyramid& tables() const { return tables_; }
  /// What grids and tables take.
  [[nodiscard]] std::size_t memory_bytes() const;

 private:
  template <class LayRays>
  Result<void> insert_everywhere(const LayRays& lay_rays);
  [[nodiscard]] Result<void> check_room(std::size_t level, const CellBox& changed) const;
  [[nodiscard]] static int margin(const OccupancyGrid& grid);
  Result<void> follow(std::size_t level, const CellBox& changed);

  MultiResolutionOptions options_;
  std::vector<OccupancyGrid> grids_;  // coarse to fine
  ProbabilityPyramid tables_;
  ScanRaster raster_;
};

}  // namespace wayfare
