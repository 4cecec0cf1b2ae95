#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <wayfare/map/likelihood_field.hpp>

namespace wayfare {

/// A LikelihoodField and upper bounds over its windows, for branch and bound. Level l holds, for
/// every place (in units of 4^l cells), the maximum over the window of 4^(l+1) cells that starts
/// there (for l > 0 one unit more, so that it holds from wherever in the unit the window starts),
/// in sixteenths of a value rounded up. The sixteen windows 4 units apart lie side by side: one
/// load bounds a block of 16×16 units. Below level 0, the maxima of pairs of rows and columns.
class PrecomputationGrids {
 public:
  static constexpr int kLevels = 3;

  struct Level {
    int width = 0, height = 0;  ///< of the grid, in units, rounded up
    int columns = 0, rows = 0;  ///< of one interleaved plane, bytes and rows
    std::vector<std::uint8_t> table;
  };

  PrecomputationGrids() = default;
  explicit PrecomputationGrids(LikelihoodField grid) { build(std::move(grid)); }

  /// Takes the grid over; memory of an earlier build is used again.
  void build(LikelihoodField grid);

  [[nodiscard]] const LikelihoodField& grid() const { return grid_; }
  [[nodiscard]] const Level& level(int l) const { return levels_[static_cast<std::size_t>(l)]; }
  /// Of the window of 2×2 cells that starts at each, laid out as grid().data() is.
  [[nodiscard]] const std::uint8_t* pairs() const {
    return pairs_.data() + std::ptrdiff_t{grid_.stride() + 1} * LikelihoodField::kBorder;
  }

 private:
  void keep_pairs(int stride);

  LikelihoodField grid_;
  std::array<Level, kLevels> levels_;
  std::vector<std::uint8_t> pairs_, units_, windows_, row_;
};

}  // namespace wayfare
