#pragma once

#include <cstdint>
#include <vector>

#include <wayfare/core/result.hpp>
#include <wayfare/map/detail/padded_table.hpp>
#include <wayfare/map/occupancy_grid.hpp>

namespace wayfare {

/// Occupancy as scan-to-map matchers read it: the probability p of every cell as p · kOne, the same
/// outside the map as in cells nobody observed.
class ProbabilityGrid : public PaddedTable {
 public:
  static constexpr int kOne = 4080;

  ProbabilityGrid() = default;

  [[nodiscard]] double probability(const Cell& map_cell) const {
    return static_cast<double>(value(map_cell)) / kOne;
  }

  /// The value of a cell nobody observed.
  [[nodiscard]] int unknown() const { return unknown_; }

  /// The table of `grid` with room for `margin` cells about what was observed, made anew in its own
  /// memory. Refused, and left empty: a grid without an observed cell, an unknown probability
  /// outside [0, 1], more cells than a table may have.
  Result<void> make(const OccupancyGrid& grid, double unknown_probability, int margin = 0);

  /// The cells of the table `make` would give a grid with these bounds. Refused as by it.
  [[nodiscard]] static Result<CellBox> extent(const CellBox& bounds, double unknown_probability,
                                              int margin);

  [[nodiscard]] bool covers(const CellBox& box) const {
    const CellBox mine{origin(), origin() + Cell{width() - 1, height() - 1}};
    return !empty() && mine.contains(box.min) && mine.contains(box.max);
  }
  /// Makes the cells of `box` anew after `grid` was updated there. False, with nothing done, where
  /// the table does not cover the box.
  bool update(const OccupancyGrid& grid, const CellBox& box);

 private:
  void copy(const OccupancyGrid& grid, const CellBox& box);

  std::uint16_t unknown_ = 0;
};

/// Tables of the same place, coarse to fine.
using ProbabilityPyramid = std::vector<ProbabilityGrid>;

}  // namespace wayfare
