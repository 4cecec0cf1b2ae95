#pragma once

// The cells of a segment as raster indices, several times faster than cell by cell.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <utility>

#include <wayfare/map/cell.hpp>

namespace wayfare {

/// A row-major window of the plane: cell c is at (c.y − origin.y)·stride + c.x − origin.x.
struct RasterShape {
  Cell origin;
  std::ptrdiff_t stride = 0;

  [[nodiscard]] std::ptrdiff_t at(const Cell& c) const {
    return (std::ptrdiff_t{c.y} - origin.y) * stride + (std::ptrdiff_t{c.x} - origin.x);
  }
};

namespace detail {

/// A segment along its longer axis ("columns"; across it "rows"). The crossing of the line between
/// two columns is a fixed-point number, slightly too large. Crossings are multiples of
/// 1/(2¹²·length) and the error stays below that, so rounding down is exact.
struct ColumnWalk {
  static constexpr int kBits = 48;
  static constexpr std::int64_t kMaxColumns = 2000;  // 3·(columns + 1)²·2²⁴ < 2⁴⁸
  static constexpr std::int64_t kMaxRow = 1 << 14;   // rows · 2⁴⁸ fit 63 bits

  std::int64_t columns;  // lines crossed
  std::ptrdiff_t column_step, row_step;
  std::ptrdiff_t start;  // index of row 0 in the first column
  std::int64_t first_row, last_row;
  std::int64_t crossing = 0, slope = 0;
  std::int64_t below = 0;  // added to a crossing gives one just before it

  /// `along`, `across`: a and b relative to the raster, in 1/4096 of a cell.
  ColumnWalk(std::int64_t a_along, std::int64_t b_along, std::int64_t a_across,
             std::int64_t b_across, std::ptrdiff_t column, std::ptrdiff_t row) {
    constexpr std::int64_t kOne = std::int64_t{1} << SubCellPoint::kBits;
    const bool forward = b_along >= a_along, up = b_across >= a_across;
    const std::int64_t in_column = a_along & (kOne - 1), first = a_along >> SubCellPoint::kBits;
    columns = std::abs((b_along >> SubCellPoint::kBits) - first);
    column_step = forward ? column : -column;
    row_step = row;
    start = static_cast<std::ptrdiff_t>(first) * column;
    first_row = a_across >> SubCellPoint::kBits;
    last_row = b_across >> SubCellPoint::kBits;
    if (!fits()) return;
    const double length =
        static_cast<double>(std::max<std::int64_t>(1, std::abs(b_along - a_along)));
    const double rise = static_cast<double>(std::abs(b_across - a_across));
    const double to_first = static_cast<double>(forward ? kOne - in_column : in_column);
    slope = static_cast<std::int64_t>(rise / length * 0x1p48);
    const auto rise_to_first = static_cast<std::int64_t>(to_first * rise / length * 0x1p36);
    crossing = a_across * (std::int64_t{1} << 36) + (up ? rise_to_first : -rise_to_first);
    crossing += columns + 1;  // slope and start are each off by less than one
    below = -3 * (columns + 1);
    if (!up) slope = -slope;
  }

  [[nodiscard]] bool fits() const {
    return columns <= kMaxColumns && std::max(first_row, last_row) < kMaxRow;
  }

  template <class Visit>
  void run(Visit&& visit) const {
    // Through a corner of cells the walk is diagonal. Going up, it leaves the old column just
    // before the corner and enters the new one at it; going down, the reverse.
    const bool up = slope > 0;
    const std::int64_t leave = up ? below : 0, enter = up ? 0 : below;
    const auto [low, high] = std::minmax(first_row, last_row);
    std::ptrdiff_t column = start;
    std::int64_t at = crossing, row = first_row;
    visit(column + row * row_step, true);
    for (std::int64_t i = 0; i < columns; ++i, at += slope) {
      const std::int64_t last = std::clamp((at + leave) >> kBits, low, high);
      visit(column + last * row_step, last != row);
      column += column_step;
      row = std::clamp((at + enter) >> kBits, low, high);
      visit(column + row * row_step, true);
    }
    visit(column + last_row * row_step, last_row != row);
  }
};

}  // namespace detail

/// Calls `visit(index, is_new)` with the raster index of each cell that for_each_cell_on_segment
/// visits; `is_new` is false when a cell is repeated directly. The segment must be within the
/// raster.
template <class Visit>
void for_each_index_on_segment(const SubCellPoint& a, const SubCellPoint& b,
                               const RasterShape& raster, Visit&& visit) {
  const std::int64_t x0 = std::int64_t{raster.origin.x} << SubCellPoint::kBits;
  const std::int64_t y0 = std::int64_t{raster.origin.y} << SubCellPoint::kBits;
  const bool flat = std::abs(b.x - a.x) >= std::abs(b.y - a.y);
  const detail::ColumnWalk walk =
      flat ? detail::ColumnWalk(a.x - x0, b.x - x0, a.y - y0, b.y - y0, 1, raster.stride)
           : detail::ColumnWalk(a.y - y0, b.y - y0, a.x - x0, b.x - x0, raster.stride, 1);
  if (walk.fits()) return walk.run(std::forward<Visit>(visit));
  for_each_cell_on_segment(a, b, [&](const Cell& c) { visit(raster.at(c), true); });
}

}  // namespace wayfare
