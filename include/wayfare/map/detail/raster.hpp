#pragma once

// The cells of a segment as raster indices, several times faster than cell by cell. And polygons of
// the sensor and the ends of neighbouring beams, filled by the parity of the number of edges left
// of a cell's centre.

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <numbers>
#include <span>
#include <utility>
#include <vector>

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

namespace detail {

/// Flips the first mark of each row whose centre is right of or on the edge, for rows whose centres
/// are between its ends (the upper excluded). Of polygons that share an edge, exactly one contains
/// a centre on it. Exact for rasters of up to 8192 cells a side.
inline void flip_along_edge(SubCellPoint a, SubCellPoint b, const RasterShape& raster,
                            std::span<std::uint8_t> marks) {
  constexpr std::int64_t kOne = std::int64_t{1} << SubCellPoint::kBits;
  if (a.y > b.y) std::swap(a, b);
  const auto first_centre_from = [](std::int64_t y) {
    return (y + kOne / 2 - 1) >> SubCellPoint::kBits;
  };
  const std::int64_t end = first_centre_from(b.y), begin = first_centre_from(a.y);
  const auto dx = static_cast<double>(b.x - a.x), dy = static_cast<double>(b.y - a.y);
  const auto x0 =
      static_cast<double>(a.x - (std::int64_t{raster.origin.x} << SubCellPoint::kBits) - kOne / 2);
  for (std::int64_t y = begin; y < end; ++y) {
    const auto rise = static_cast<double>(y * kOne + kOne / 2 - a.y);
    const double column = (x0 * dy + rise * dx) / (dy * kOne);
    auto first = static_cast<std::ptrdiff_t>(column);
    first += static_cast<double>(first) < column ? 1 : 0;
    if (first >= raster.stride) continue;
    marks[static_cast<std::size_t>((y - raster.origin.y) * raster.stride + first)] ^= 1;
  }
}

/// Replaces each mark (0 or 1) by the parity of the marks up to it. `n` is a multiple of 8.
inline void running_parity(std::uint8_t* marks, std::ptrdiff_t n) {
  if constexpr (std::endian::native == std::endian::little) {
    // The product's bytes are the running sums of the word's.
    constexpr std::uint64_t kOnes = 0x0101010101010101;
    std::uint64_t before = 0;
    for (std::ptrdiff_t i = 0; i < n; i += 8) {
      std::uint64_t word;
      std::memcpy(&word, marks + i, 8);
      word = (word * kOnes & kOnes) ^ before;
      std::memcpy(marks + i, &word, 8);
      before = (std::uint64_t{0} - (word >> 56)) & kOnes;
    }
  } else {
    for (std::ptrdiff_t i = 1; i < n; ++i) marks[i] ^= marks[i - 1];
  }
}

/// Which beams have a next neighbour in scan direction: at most `gap_rad` further, within the first
/// revolution. `Ray` has `end` and `bearing_rad`.
template <class Ray>
void find_neighbours(std::span<const Ray> rays, const SubCellPoint& origin, double gap_rad,
                     std::vector<std::uint8_t>& has_next) {
  using std::numbers::pi;
  const auto bearing_step = [&](std::size_t i) {
    const Ray& next = rays[i + 1 == rays.size() ? 0 : i + 1];
    return std::remainder(
        static_cast<double>(next.bearing_rad) - static_cast<double>(rays[i].bearing_rad), 2 * pi);
  };
  double direction = 0.0;
  for (std::size_t i = 0; i + 1 < rays.size(); ++i) direction += bearing_step(i) > 0 ? 1 : -1;
  direction = direction < 0 ? -1 : 1;
  double swept = 0.0;
  has_next.assign(rays.size(), 0);
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const double step = direction * bearing_step(i);
    swept += step < -gap_rad ? step + 2 * pi : step;  // a large step back wraps to a forward one
    const SubCellPoint &a = rays[i].end, &b = rays[i + 1 == rays.size() ? 0 : i + 1].end;
    const double cross = static_cast<double>(a.x - origin.x) * static_cast<double>(b.y - origin.y) -
                         static_cast<double>(a.y - origin.y) * static_cast<double>(b.x - origin.x);
    has_next[i] = step > 0 && step <= gap_rad && swept < 2 * pi + 1e-4 && direction * cross > 0;
  }
}

/// Marks the cells whose centres are between neighbouring rays. `marks` must be zero before.
template <class Ray>
void fill_polygon(std::span<const Ray> rays, std::span<const std::uint8_t> has_next,
                  const SubCellPoint& origin, const RasterShape& raster, std::int64_t rows,
                  std::span<std::uint8_t> marks) {
  bool before = has_next.back() != 0;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const bool next = has_next[i] != 0;
    // Edges to the sensor between two filled sectors cancel, so they are skipped.
    if (next != before) flip_along_edge(origin, rays[i].end, raster, marks);
    if (next)
      flip_along_edge(rays[i].end, rays[i + 1 == rays.size() ? 0 : i + 1].end, raster, marks);
    before = next;
  }
  for (std::int64_t y = 0; y < rows; ++y)
    running_parity(marks.data() + y * raster.stride, raster.stride);
}

}  // namespace detail

}  // namespace wayfare
