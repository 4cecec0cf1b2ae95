#pragma once

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
  [[nodiscard]] double log_step() const { return log_step_; }
  [[nodiscard]] double log_likelihood(const Cell& map_cell) const {
    return log_floor_ + log_step_ * value(map_cell);
  }

  /// Resizes to `box` (map cells) and sets all values to zero, reusing memory. Errors: resolution
  /// or floor out of range, more than kMaxCells.
  Result<void> reset(double resolution_m, const CellBox& box, double floor_probability);

 private:
  double log_floor_ = 0.0, log_step_ = 0.0;
};

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
  SE2d T_map_points;
};

struct LikelihoodFieldOptions {
  double resolution_m = 0.05;
  /// Standard deviation of a point about the surface it measures, m.
  double sigma_m = 0.1;
  /// Probability of a point far from every surface. The kernel ends at σ√(−2 ln floor), at most 30
  /// cells.
  double floor_probability = 0.01;
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

[[nodiscard]] Result<LikelihoodField> likelihood_field(std::span<const PlacedPoints> scans,
                                                       const LikelihoodFieldOptions& options = {});

}  // namespace wayfare
