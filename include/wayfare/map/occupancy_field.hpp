#pragma once

#include <cstdint>
#include <vector>

#include <wayfare/core/result.hpp>
#include <wayfare/core/se2.hpp>
#include <wayfare/map/likelihood_field.hpp>
#include <wayfare/map/occupancy_grid.hpp>
#include <wayfare/sensors/point_set.hpp>

namespace wayfare {

struct OccupancyFieldOptions {
  /// Standard deviation of a point about the cell it measures, m.
  double sigma_m = 0.06;
  /// Probability given to a point far from everything; also ends the kernel, at σ√(−2 ln floor), at
  /// most 15 cells.
  double floor_probability = 0.2;
  /// Cells less likely occupied than this attract nothing.
  double min_probability = 0.5;
};

/// How far a scan may move about the pose it is expected at.
struct FieldReach {
  double translation_m = 0.3;
  double heading_rad = 0.1;
};

/// ln p = max over occupied cells q of ln p(q) − |c − q|²/2σ², not below the floor: the likelihood
/// field (Thrun et al. 2005, 6.4) of an occupancy grid, made only where the points of one scan can
/// come to lie. A particle's map is kept as tiles it shares with others; this is the row-major view
/// matching wants, made for one scan in a few microseconds and then used for thousands of poses.
/// Farther than the reach from the points' expected places the view holds no promise.
class OccupancyFieldMaker {
 public:
  /// Makes `view` in its own memory. Errors: no points, a pose or points that are not finite or too
  /// far apart, options out of range; then `view` is left empty.
  Result<void> make(const OccupancyGrid& grid, const PointSet& points, const SE2d& T_map_points,
                    const FieldReach& reach, const OccupancyFieldOptions& options,
                    LikelihoodField& view);

 private:
  void prepare_kernels(const OccupancyFieldOptions& options, double resolution_m);
  Result<CellBox> place(const PointSet& points, const SE2d& pose, double resolution_m);
  [[nodiscard]] CellBox reachable_blocks(const CellBox& box, float max_norm_m,
                                         const FieldReach& reach, double resolution_m) const;
  void mark(const PointSet& points, const FieldReach& reach, double resolution_m);
  void stamp_block(const OccupancyGrid::Tiles::Tile& tile, const Cell& corner,
                   LikelihoodField& view);

  OccupancyFieldOptions prepared_{0.0, 0.0, 0.0};
  double prepared_resolution_m_ = 0.0;
  int radius_ = 0, kernel_width_ = 0;
  std::int16_t threshold_ = 0;
  std::vector<std::uint16_t> kernels_;  // [bin of log-odds][row][column]
  std::vector<std::int32_t> u_, v_;     // the points' cells, from base_
  Cell base_;
  CellBox blocks_;                   // of 16×16 cells
  std::vector<std::uint8_t> marks_;  // of blocks, row-major
};

}  // namespace wayfare
