#pragma once

// Base of the tables that kernels read: row-major cells with a border on every side, so that a
// kernel that clamps an index into the border needs no further checks.

#include <cstddef>
#include <cstdint>
#include <vector>

#include <wayfare/core/detail/reset_on_move.hpp>
#include <wayfare/core/result.hpp>
#include <wayfare/map/cell.hpp>

namespace wayfare {

/// What was moved from is empty(), and must be made or assigned before its cells are read.
class PaddedTable {
 public:
  static constexpr int kBorder = 32;  ///< cells around the table that may be read
  /// Upper limit of a table's size (128 MiB).
  static constexpr std::int64_t kMaxCells = std::int64_t{1} << 26;

  /// Side of a cell, m.
  [[nodiscard]] double resolution_m() const { return resolution_m_; }
  /// The map cell at column 0, row 0.
  [[nodiscard]] Cell origin() const { return origin_; }
  /// Columns, without the border.
  [[nodiscard]] int width() const { return width_; }
  /// Rows, without the border.
  [[nodiscard]] int height() const { return height_; }
  /// Whether it has no cells.
  [[nodiscard]] bool empty() const { return width_ == 0; }

  /// Cells outside the table have the border's value.
  [[nodiscard]] int value(const Cell& map_cell) const {
    const Cell c = map_cell - origin_;
    if (c.x < 0 || c.y < 0 || c.x >= width_ || c.y >= height_) return table_.front();
    return data()[static_cast<std::ptrdiff_t>(c.y) * stride() + c.x];
  }

  /// Column 0 of row 0; rows are stride() apart, and kBorder cells on every side may be read.
  [[nodiscard]] const std::uint16_t* data() const { return table_.data() + first(); }
  /// Column 0 of row 0, to change it.
  [[nodiscard]] std::uint16_t* data() { return table_.data() + first(); }
  /// Numbers from row to row.
  [[nodiscard]] int stride() const { return width_ + 2 * kBorder; }

 protected:
  PaddedTable() = default;
  /// Errors: a box without a cell, or of more than kMaxCells.
  static Result<void> check_size(const CellBox& box);
  /// Resizes the table to `box` (map cells) and fills it and its border with `fill`, reusing
  /// memory. Errors, with the table left empty: resolution not positive, more than kMaxCells.
  Result<void> reset(double resolution_m, const CellBox& box, std::uint16_t fill);

 private:
  [[nodiscard]] std::ptrdiff_t first() const {
    return static_cast<std::ptrdiff_t>(stride()) * kBorder + kBorder;
  }

  double resolution_m_ = 0.05;
  Cell origin_;
  ResetOnMove<int> width_, height_;
  std::vector<std::uint16_t> table_ =
      std::vector<std::uint16_t>(static_cast<std::size_t>(4 * kBorder) * kBorder, std::uint16_t{0});
};

}  // namespace wayfare
