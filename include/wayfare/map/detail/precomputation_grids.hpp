#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <wayfare/map/likelihood_field.hpp>

namespace wayfare {

/// Precomputation grids of a LikelihoodField for branch and bound (Hess et al. 2016). Level l
/// stores, at every index (in units of 4^l cells), the maximum over the window of 4^(l+1) cells
/// that starts there (for l > 0 one unit more, so that it bounds windows that start anywhere in the
/// unit), in sixteenths of a value, rounded up. The sixteen windows 4 units apart are adjacent in
/// memory: one load bounds a block of 16×16 units. pairs() has the maxima of 2×2 cells.
class PrecomputationGrids {
 public:
  static constexpr int kLevels = 3;  ///< of 4, 16 and 64 cells

  /// One of the grids.
  struct Level {
    int width = 0,                    ///< units along x
        height = 0;                   ///< units along y
    int columns = 0,                  ///< bytes of a plane
        rows = 0;                     ///< rows of a plane
    std::vector<std::uint8_t> table;  ///< planes, one after the other
  };

  PrecomputationGrids() = default;
  /// As build().
  explicit PrecomputationGrids(LikelihoodField grid) { build(std::move(grid)); }

  /// Takes ownership of the grid; reuses the memory of an earlier build.
  void build(LikelihoodField grid);
  /// Frees what only another build() would use.
  void release_workspace() { units_ = windows_ = row_ = {}; }

  /// The likelihood field of the cells.
  [[nodiscard]] const LikelihoodField& grid() const { return grid_; }
  /// Level l < kLevels.
  [[nodiscard]] const Level& level(int l) const { return levels_[static_cast<std::size_t>(l)]; }
  /// Maximum of the window of 2×2 cells that starts at each cell, in the layout of grid().data().
  [[nodiscard]] const std::uint8_t* pairs() const {
    return pairs_.data() + std::ptrdiff_t{grid_.stride() + 1} * LikelihoodField::kBorder;
  }

 private:
  void store_pairs(int stride);

  LikelihoodField grid_;
  std::array<Level, kLevels> levels_;
  std::vector<std::uint8_t> pairs_, units_, windows_, row_;
};

}  // namespace wayfare
