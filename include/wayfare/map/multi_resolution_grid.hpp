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
  int levels = 3;  ///< cells of each are twice as wide as those of the next
  InverseLidarModel model{.p_free = 0.4, .p_hit = 0.9};
  double unknown_probability = 0.5;  ///< of a cell that was not observed
};

/// Occupancy grids at several resolutions, each updated with every scan (Kohlbrecher et al. 2011),
/// and the probability tables that scan matchers read.
class MultiResolutionGrid {
 public:
  explicit MultiResolutionGrid(const MultiResolutionOptions& options = {});

  /// Inserts a scan into every grid and updates the tables. Errors: those of `insert_scan`, or a
  /// table would grow too large; then nothing has changed.
  Result<void> insert(const SE2d& T_map_laser, const LaserScan& scan);
  /// The same for end points of rays that begin at `origin`; see `insert_points`.
  Result<void> insert(const SE2d& T_map_points, const PointSet& points,
                      const Eigen::Vector2d& origin = Eigen::Vector2d::Zero());

  [[nodiscard]] bool empty() const { return tables_.empty(); }
  [[nodiscard]] const OccupancyGrid& finest() const { return grids_.back(); }
  /// Coarse to fine; empty before the first scan.
  [[nodiscard]] const ProbabilityPyramid& tables() const { return tables_; }
  /// Of grids and tables.
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
