#pragma once

// Likelihood fields: of scans, of occupancy grids and of detections.

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <wayfare/core/result.hpp>
#include <wayfare/core/se2.hpp>
#include <wayfare/map/cell.hpp>
#include <wayfare/map/detail/padded_table.hpp>
#include <wayfare/map/occupancy_grid.hpp>
#include <wayfare/sensors/point_set.hpp>

namespace wayfare {

/// The log-likelihood of a scan point in every cell, quantised to `ln p = floor + step · value`,
/// value in [0, kMaxValue], 0 outside.
class LikelihoodField : public PaddedTable {
 public:
  /// 255·16: in sixteenths, rounded up, it fits a byte, and a sum of 16 values fits 16 bits.
  static constexpr int kMaxValue = 4080;

  LikelihoodField() = default;

  /// ln p of value 0, and of one unit of value.
  [[nodiscard]] double log_floor() const { return log_floor_; }
  /// ln p of one unit of value.
  [[nodiscard]] double log_step() const { return log_step_; }
  /// ln p of a scan point in this cell, nats.
  [[nodiscard]] double log_likelihood(const Cell& map_cell) const {
    return log_floor_ + log_step_ * value(map_cell);
  }

  /// Resizes to `box` (map cells) and sets all values to zero, reusing memory. Errors: resolution
  /// or floor out of range, more than kMaxCells.
  Result<void> reset(double resolution_m, const CellBox& box, double floor_probability);

 private:
  double log_floor_ = 0.0, log_step_ = 0.0;
};

/// How occupancy probabilities become likelihoods.
struct OccupancyViewOptions {
  /// Lower bound of the probability of a point; that of points outside the map.
  double floor_probability = 0.05;
  /// Standard deviation of a Gaussian blur of the probabilities, m: widens the basin of attraction.
  double blur_sigma_m = 0.0;
  /// Occupancy probability of a cell that was not observed.
  double unknown_probability = 0.05;
};

/// ln of the occupancy probability of every cell.
[[nodiscard]] Result<LikelihoodField> likelihood_field(const OccupancyGrid& grid,
                                                       const OccupancyViewOptions& options = {});

/// Points and their pose in the map.
struct PlacedPoints {
  const PointSet* points = nullptr;  ///< null: an Error
  SE2d T_map_points;                 ///< pose of the points' frame in the map
};

/// Cells and kernel of a likelihood field of scans.
struct LikelihoodFieldOptions {
  double resolution_m = 0.05;  ///< side of a cell
  /// Standard deviation of a point about the surface it measures, m.
  double sigma_m = 0.1;
  /// Probability of a point far from every surface. The kernel ends at σ√(−2 ln floor), at most 30
  /// cells.
  double floor_probability = 0.01;
  /// Whether all options are equal.
  bool operator==(const LikelihoodFieldOptions&) const = default;
};

/// ln p = max over the placed points q of −|c − q|²/2σ², at cell centres c, not below the floor: a
/// likelihood field (Thrun et al. 2005, 6.4) without an intermediate occupancy grid. Each point's
/// position is rounded to a quarter of a cell.
class LikelihoodFieldMaker {
 public:
  /// Rebuilds `grid`, reusing its memory. Errors, with `grid` left empty: points or poses that are
  /// not finite, more than LikelihoodField::kMaxCells.
  Result<void> make(std::span<const PlacedPoints> scans, const LikelihoodFieldOptions& options,
                    LikelihoodField& grid);

 private:
  void prepare_kernels(const LikelihoodFieldOptions& options);
  Result<CellBox> place(std::span<const PlacedPoints> scans, double resolution_m);

  LikelihoodFieldOptions prepared_{0.0, 0.0, 0.0};
  int radius_ = 0, kernel_width_ = 0;
  std::vector<std::uint16_t> kernels_;  // [phase y][phase x][row][column]
  std::vector<std::int32_t> x_, y_;     // placed points, quarter cells from base_
  Cell base_;
};

/// The field of LikelihoodFieldMaker, in memory of its own. Errors as there.
[[nodiscard]] Result<LikelihoodField> likelihood_field(std::span<const PlacedPoints> scans,
                                                       const LikelihoodFieldOptions& options = {});

/// Kernel and threshold of a likelihood field of an occupancy grid.
struct OccupancyFieldOptions {
  /// Standard deviation of a point about the cell it measures, m.
  double sigma_m = 0.06;
  /// Probability of a point far from every surface. The kernel ends at σ√(−2 ln floor), at most 15
  /// cells.
  double floor_probability = 0.2;
  /// Cells with a smaller occupancy probability are ignored.
  double min_probability = 0.5;
  /// Whether all options are equal.
  bool operator==(const OccupancyFieldOptions&) const = default;
};

/// Largest deviation of a scan from its expected pose.
struct FieldReach {
  double translation_m = 0.3;  ///< in any direction
  double heading_rad = 0.1;    ///< to either side
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

/// For the map of a sensor that gives detections but no free space: every detection adds the
/// log-odds of a probability to its cell. The clamping leaves room for 370 detections of
/// probability 0.52, or 35 of 0.7; the clamping of occupancy maps saturates after five.
[[nodiscard]] inline OccupancyGridOptions detection_map(double resolution_m = 0.03) {
  return {resolution_m, 1e-13, 1.0 - 1e-13};
}

/// How a grid of detections becomes a density.
struct DetectionViewOptions {
  double hit_probability = 0.52;  ///< the one the map was built with
  /// Standard deviation of a detection about the object detected, m.
  double blur_sigma_m = 0.03;
  /// Number of detections assumed in every cell, so that new objects and ghosts have little effect.
  double background = 0.02;
  /// Upper bound of the density after the blur, detections. 0: the map's maximum. The scores of
  /// different maps are comparable only if it is the same for all.
  double max_detections = 0.0;
};

/// ln of the density of detections at every cell relative to the maximum. For a sensor with
/// repeated detections of the same objects and clutter between them, the density is informative
/// where the occupancy probabilities have all saturated at 1.
[[nodiscard]] Result<LikelihoodField> detection_grid(const OccupancyGrid& grid,
                                                     const DetectionViewOptions& options = {});

/// The same, only for the cells that the points of one scan can reach, built for every scan and
/// particle. Its values farther than `reach` from the points' expected positions are undefined.
class DetectionFieldMaker {
 public:
  /// Rebuilds `view`, reusing its memory. Errors, with `view` left empty: no points, a pose or
  /// points that are not finite or too far apart, options out of range (`max_detections` must be
  /// positive).
  Result<void> make(const OccupancyGrid& grid, const PointSet& points, const SE2d& T_map_points,
                    const FieldReach& reach, const DetectionViewOptions& options,
                    LikelihoodField& view);

 private:
  void prepare_kernel(double sigma_cells);
  void spread(const OccupancyGrid& grid, const CellBox& box, double hit_nats);
  void write(const DetectionViewOptions& options, LikelihoodField& view) const;

  int radius_ = -1;
  double sigma_cells_ = -1.0;
  std::vector<float> kernel_;   // rows of 2 radius + 1
  std::vector<float> density_;  // row-major, the view's cells
};

}  // namespace wayfare
