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
  /// Probability of a point far from every surface. The kernel ends at σ√(−2 ln floor), at most 15
  /// cells.
  double floor_probability = 0.2;
  /// Cells with a smaller occupancy probability are ignored.
  double min_probability = 0.5;
  bool operator==(const OccupancyFieldOptions&) const = default;
};

/// Largest deviation of a scan from its expected pose.
struct FieldReach {
  double translation_m = 0.3;
  double heading_rad = 0.1;
};

/// ln p = max over occupied cells q of ln p(q) − |c − q|²/2σ², not below the floor: the likelihood
/// field (Thrun et al. 2005, 6.4) of an occupancy grid, only for the cells that the points of one
/// scan can reach. A particle's map consists of tiles shared with other particles; this is the
/// row-major view that matching needs, built in a few microseconds and used for thousands of poses.
/// Its values farther than `reach` from the points' expected positions are undefined.
class OccupancyFieldMaker {
 public:
  /// Rebuilds `view`, reusing its memory. Errors, with `view` left empty: no points, a pose or
  /// points that are not finite or too far apart, options out of range.
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
  std::vector<std::int32_t> u_, v_;     // the points' cells, relative to base_
  Cell base_;
  CellBox blocks_;                   // of 16×16 cells
  std::vector<std::uint8_t> marks_;  // of blocks, row-major
};

}  // namespace wayfare
