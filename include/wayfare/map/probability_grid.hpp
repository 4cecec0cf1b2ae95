#pragma once

// Tables of occupancy probabilities, and grids at several resolutions.

#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include <wayfare/core/result.hpp>
#include <wayfare/map/detail/padded_table.hpp>
#include <wayfare/map/detail/scan_raster.hpp>
#include <wayfare/map/inverse_lidar.hpp>
#include <wayfare/map/occupancy_grid.hpp>

namespace wayfare {

/// Occupancy probability p of every cell for scan-to-map matchers, as p · kOne; cells outside the
/// map have the value of unobserved ones.
class ProbabilityGrid : public PaddedTable {
 public:
  static constexpr int kOne = 4080;  ///< value of probability 1

  ProbabilityGrid() = default;

  /// Probability of being occupied; of cells outside, that of unobserved ones.
  [[nodiscard]] double probability(const Cell& map_cell) const {
    return static_cast<double>(value(map_cell)) / kOne;
  }

  /// The value of an unobserved cell.
  [[nodiscard]] int unknown() const { return unknown_; }

  /// Rebuilds the table from `grid` with a margin of `margin` cells about the observed ones,
  /// reusing memory. Errors, with the table left empty: no observed cell, an unknown probability
  /// outside [0, 1], a negative margin, more than kMaxCells.
  Result<void> make(const OccupancyGrid& grid, double unknown_probability, int margin = 0);
  /// The same of the cells of `box`.
  Result<void> make(const OccupancyGrid& grid, double unknown_probability, const CellBox& box);

  /// Whether `make` can build a table of the cells of `box`. Errors as there.
  [[nodiscard]] static Result<void> check(const CellBox& box, double unknown_probability);

  /// The cells of a table that is not empty.
  [[nodiscard]] CellBox box() const {
    return {origin(), origin() + Cell{width() - 1, height() - 1}};
  }
  /// Whether all cells of the box are in the table.
  [[nodiscard]] bool covers(const CellBox& box) const {
    const CellBox mine = this->box();
    return !empty() && mine.contains(box.min) && mine.contains(box.max);
  }
  /// Updates the cells of `box` from `grid`. False, with nothing changed, if the table does not
  /// cover the box.
  bool update(const OccupancyGrid& grid, const CellBox& box);

 private:
  void copy(const OccupancyGrid& grid, const CellBox& box);

  std::uint16_t unknown_ = 0;
};

/// Tables of the same area, coarse to fine.
using ProbabilityPyramid = std::vector<ProbabilityGrid>;

/// Resolutions and sensor model of a MultiResolutionGrid.
struct MultiResolutionOptions {
  OccupancyGridOptions finest{};  ///< of the last level
  int levels = 3;                 ///< cells of each are twice as wide as those of the next
  InverseLidarModel model{.p_free = 0.4, .p_hit = 0.9};  ///< of every level
  double unknown_probability = 0.5;                      ///< of a cell that was not observed
  /// Tables contain the cells this far from the latest scan's origin or the latest `focus`, along
  /// both axes, m; those farther count as not observed. Infinite: all cells.
  double table_reach_m = std::numeric_limits<double>::infinity();
};

/// Occupancy grids at several resolutions, each updated with every scan (Kohlbrecher et al. 2011),
/// and the probability tables that scan matchers read. A moved-from object can only be destroyed or
/// assigned to.
class MultiResolutionGrid {
 public:
  /// Empty grids. Requires the same as OccupancyGrid of `finest`.
  explicit MultiResolutionGrid(const MultiResolutionOptions& options = {});

  /// Inserts a scan into every grid and updates the tables. Errors: those of `insert_scan`, or a
  /// table would grow too large; then nothing has changed.
  Result<void> insert(const SE2d& T_map_laser, const LaserScan& scan);
  /// The same for end points of rays that begin at `origin`; see `insert_points`.
  Result<void> insert(const SE2d& T_map_points, const PointSet& points,
                      const Eigen::Vector2d& origin = Eigen::Vector2d::Zero()) {
    return insert(T_map_points, points, origin, raster_);
  }
  /// The same with scratch memory that several grids share.
  Result<void> insert(const SE2d& T_map_points, const PointSet& points,
                      const Eigen::Vector2d& origin, ScanRaster& raster);
  /// Moves the tables to a place of the map, where their reach is limited. Errors: a table would be
  /// too large; it then is empty.
  Result<void> focus(const Eigen::Vector2d& place_m);

  /// Whether no scan with a return was inserted.
  [[nodiscard]] bool empty() const { return tables_.empty(); }
  /// The grid with the smallest cells.
  [[nodiscard]] const OccupancyGrid& finest() const { return grids_.back(); }
  /// Coarse to fine; empty before the first scan with a return.
  [[nodiscard]] const ProbabilityPyramid& tables() const { return tables_; }
  /// Of grids and tables.
  [[nodiscard]] std::size_t memory_bytes() const;

 private:
  template <class LayRays>
  Result<void> insert_everywhere(const LayRays& lay_rays, ScanRaster& raster);
  [[nodiscard]] CellBox near(std::size_t level, const Cell& at, double more_m) const;
  [[nodiscard]] CellBox with_spare(std::size_t level, const CellBox& bounds, const Cell& at) const;
  [[nodiscard]] Result<void> check_room(std::size_t level, const CellBox& changed,
                                        const Cell& at) const;
  Result<void> follow(std::size_t level, const Cell& at);

  MultiResolutionOptions options_;
  std::vector<OccupancyGrid> grids_;  // coarse to fine
  ProbabilityPyramid tables_;
  ScanRaster raster_;
};

}  // namespace wayfare
