#pragma once

#include <cstdint>
#include <vector>

#include <wayfare/core/result.hpp>
#include <wayfare/map/detail/padded_table.hpp>
#include <wayfare/map/occupancy_grid.hpp>

namespace wayfare {

/// Occupancy probability p of every cell for scan-to-map matchers, as p · kOne; cells outside the
/// map have the value of unobserved ones.
class ProbabilityGrid : public PaddedTable {
 public:
  static constexpr int kOne = 4080;

  ProbabilityGrid() = default;

  [[nodiscard]] double probability(const Cell& map_cell) const {
    return static_cast<double>(value(map_cell)) / kOne;
  }

  /// The value of an unobserved cell.
  [[nodiscard]] int unknown() const { return unknown_; }

  /// Rebuilds the table from `grid` with a margin of `margin` cells about the observed ones,
  /// reusing memory. Errors, with the table left empty: no observed cell, an unknown probability
  /// outside [0, 1], more than kMaxCells.
  Result<void> make(const OccupancyGrid& grid, double unknown_probability, int margin = 0);

  /// The cells of the table `make` would build for a grid with these bounds. Errors as there.
  [[nodiscard]] static Result<CellBox> extent(const CellBox& bounds, double unknown_probability,
                                              int margin);

  [[nodiscard]] bool covers(const CellBox& box) const {
    const CellBox mine{origin(), origin() + Cell{width() - 1, height() - 1}};
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

}  // namespace wayfare
