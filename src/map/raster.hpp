#pragma once

// What one scan covers of a window of the plane: how many beams pass each cell, kept as differences
// along rows and columns, and the area between beams, kept as bits.

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <numbers>
#include <span>
#include <utility>
#include <vector>

#include <wayfare/map/cell.hpp>
#include <wayfare/map/detail/raster_shape.hpp>
#include <wayfare/map/detail/scan_raster.hpp>

namespace wayfare::detail {

/// Where a segment crosses successive grid lines, in cells along the lines, as fixed-point numbers.
/// True crossings are multiples of 1/(4096·length) and the error stays below that, so that rounding
/// down is exact.
struct LineCrossings {
  static constexpr int kBits = 48;
  static constexpr std::int64_t kMaxReach = std::int64_t{1} << (14 + SubCellPoint::kBits);

  std::int64_t at = 0;      ///< the first crossing, slightly too large
  std::int64_t slope = 0;   ///< from one crossing to the next
  std::int64_t before = 0;  ///< added to a crossing gives one slightly too small
  bool exact = true;        ///< if not, the segment is too long
  bool corners = false;     ///< a crossing can be at a corner of cells; else both round down alike

  /// In 1/4096 of a cell: the segment starts at `start` along the lines and `to_first` in front of
  /// the first of `lines` lines; it rises by `rise` along them over a `length` across them.
  LineCrossings(std::int64_t start, std::int64_t rise, std::int64_t length, std::int64_t to_first,
                std::int64_t lines) {
    if (lines == 0) return;
    // Each rounding to an integer is off by less than one; those to 53 bits together by less than
    // the rise in cells / 16.
    const std::int64_t rounding = lines + (std::abs(rise) >> (SubCellPoint::kBits + 4)) + 2;
    exact = std::abs(start) + std::abs(rise) < kMaxReach && length < kMaxReach &&
            3 * rounding * length < std::int64_t{1} << (kBits - SubCellPoint::kBits);
    if (!exact) return;
    const auto up = static_cast<double>(rise), over = static_cast<double>(length);
    const auto to_line =
        static_cast<std::int64_t>(static_cast<double>(to_first) * up / over * 0x1p36);
    at = start * (std::int64_t{1} << (kBits - SubCellPoint::kBits)) + to_line + rounding;
    before = -3 * rounding;
    // Crossing k is at start + rise·(to_first + 4096·k)/length, at a corner a multiple of 4096.
    constexpr std::int64_t kOne = std::int64_t{1} << SubCellPoint::kBits;
    corners = (start * length + rise * to_first) % kOne == 0;
    // Over one line only it could exceed 63 bits.
    if (lines > 1) slope = static_cast<std::int64_t>(up / over * 0x1p48);
  }
};

/// The runs of a segment in the grid lines it passes. Distances are in cells of a raster.
struct SegmentRuns {
  std::int64_t lines = 0;             ///< crossed
  std::int64_t enter = 0, leave = 0;  ///< first crossing, entering and leaving a line
  std::int64_t slope = 0;             ///< from one crossing to the next
  std::int64_t first = 0, last = 0;   ///< places of the ends along their lines
  std::ptrdiff_t start = 0;           ///< of the first line
  std::ptrdiff_t line = 0, cell = 0;  ///< from line to line, and along a line
  bool up = true;                     ///< towards larger places
  bool flat = true;                   ///< lines are rows
  bool exact = true;                  ///< if not, the segment is too long
  bool corners = false;               ///< it can pass corners of cells, or start or end on a line

  SegmentRuns() = default;
  SegmentRuns(const SubCellPoint& a, const SubCellPoint& b, const RasterShape& raster) {
    constexpr std::int64_t kOne = std::int64_t{1} << SubCellPoint::kBits;
    const std::int64_t x0 = std::int64_t{raster.origin.x} << SubCellPoint::kBits;
    const std::int64_t y0 = std::int64_t{raster.origin.y} << SubCellPoint::kBits;
    flat = std::abs(b.x - a.x) >= std::abs(b.y - a.y);
    // Across and along the lines.
    const std::int64_t u0 = flat ? a.y - y0 : a.x - x0, u1 = flat ? b.y - y0 : b.x - x0;
    const std::int64_t v0 = flat ? a.x - x0 : a.y - y0, v1 = flat ? b.x - x0 : b.y - y0;
    const bool forward = u1 >= u0;
    up = v1 >= v0;
    const std::int64_t first_line = u0 >> SubCellPoint::kBits, in_line = u0 & (kOne - 1);
    lines = std::abs((u1 >> SubCellPoint::kBits) - first_line);
    const LineCrossings c(v0, v1 - v0, std::abs(u1 - u0), forward ? kOne - in_line : in_line,
                          lines);
    exact = c.exact;
    corners = c.corners;
    // Through a corner of cells the segment is diagonal. Going up, it leaves the old line just
    // before the corner and enters the new one at it; going down, the reverse.
    leave = c.at + (up ? c.before : 0);
    enter = c.at + (up ? 0 : c.before);
    slope = c.slope;
    first = v0 >> SubCellPoint::kBits;
    last = v1 >> SubCellPoint::kBits;
    line = flat ? raster.stride : 1;
    cell = flat ? 1 : raster.stride;
    start = static_cast<std::ptrdiff_t>(first_line) * line;
    if (!forward) line = -line;
  }

  /// Adds 1 at the low end of each run and subtracts it after its high end.
  template <class Count>
  void add_to(Count* differences) const {
    if (flat)
      up ? add<true>(differences, 1) : add<false>(differences, 1);
    else
      up ? add<true>(differences, cell) : add<false>(differences, cell);
  }

 private:
  template <bool kUp, class Count>
  void add(Count* differences, std::ptrdiff_t along) const {
    constexpr int kBits = LineCrossings::kBits;
    // Differences where the segment enters and leaves a line.
    constexpr int kEntered = kUp ? 1 : -1, kLeft = -kEntered;
    const auto add_at = [](Count& at, int value) { at = static_cast<Count>(at + value); };
    // It leaves a line at place 0 here, and enters the next so much further.
    Count* at = differences + start + (kUp ? along : 0);
    const std::ptrdiff_t across = line, to_enter = across + (kUp ? -along : along);
    const std::int64_t step = slope;
    std::int64_t in = enter, out = leave;
    add_at(at[first * along + to_enter - across], kEntered);
    if (corners) {
      // Rounding can leave the segment where it starts or ends on a line.
      const auto inside = [&](std::int64_t v) {
        return along * std::clamp(v >> kBits, kUp ? first : last, kUp ? last : first);
      };
      for (std::int64_t i = lines; i > 0; --i, at += across, in += step, out += step) {
        add_at(at[inside(out)], kLeft);
        add_at(at[inside(in) + to_enter], kEntered);
      }
    } else {
      for (std::int64_t i = lines; i > 0; --i, at += across, in += step) {
        Count* crossing = at + (in >> kBits) * along;
        add_at(crossing[0], kLeft);
        add_at(crossing[to_enter], kEntered);
      }
    }
    add_at(at[last * along], kLeft);
  }
};

/// How often the segments from `a` pass each cell, as for_each_cell_on_segment visits them. A flat
/// segment adds to the differences along rows, a steep one to those along columns, so the work
/// grows with the shorter of its sides. The cells, and those right of and above them, must be in
/// the raster. `Ray` has `end`.
template <class Count, class Ray>
void add_segments(const SubCellPoint& a, std::span<const Ray> rays, const RasterShape& raster,
                  PassDifferences<Count>& differences) {
  // The divisions of several segments at a time hide their latency.
  constexpr std::size_t kBatch = 16;
  std::array<SegmentRuns, kBatch> batch;
  for (; !rays.empty(); rays = rays.subspan(std::min(kBatch, rays.size()))) {
    const std::size_t n = std::min(kBatch, rays.size());
    for (std::size_t i = 0; i < n; ++i) batch[i] = SegmentRuns(a, rays[i].end, raster);
    for (std::size_t i = 0; i < n; ++i) {
      const SegmentRuns& runs = batch[i];
      auto& along = runs.flat ? differences.along_rows : differences.along_columns;
      if (runs.exact) {
        runs.add_to(along.data());
        continue;
      }
      for_each_cell_on_segment(a, rays[i].end, [&](const Cell& c) {
        const std::ptrdiff_t at = raster.at(c);
        ++along[static_cast<std::size_t>(at)];
        --along[static_cast<std::size_t>(at + runs.cell)];
      });
    }
  }
}

/// Flips the first bit of each row whose cell's centre is right of or on the edge, for rows whose
/// centres are between its ends (the upper excluded). Of polygons that share an edge, exactly one
/// contains a centre on it. Bit raster.at(c) is of cell c; the stride is a multiple of 64.
inline void flip_along_edge(SubCellPoint a, SubCellPoint b, const RasterShape& raster,
                            std::span<std::uint64_t> bits) {
  constexpr std::int64_t kOne = std::int64_t{1} << SubCellPoint::kBits;
  if (a.y > b.y) std::swap(a, b);
  // Relative to the centre of the raster's first cell.
  const std::int64_t half = kOne / 2;
  const std::int64_t x0 = (std::int64_t{raster.origin.x} << SubCellPoint::kBits) + half;
  const std::int64_t y0 = (std::int64_t{raster.origin.y} << SubCellPoint::kBits) + half;
  const auto up = [](std::int64_t v) { return (v + kOne - 1) >> SubCellPoint::kBits; };
  const std::int64_t begin = up(a.y - y0), end = up(b.y - y0);
  if (begin == end) return;
  const std::int64_t dx = b.x - a.x, dy = b.y - a.y, to_first = begin * kOne - (a.y - y0);
  const auto flip = [&](std::int64_t row, std::int64_t column) {
    const std::int64_t at = row * raster.stride + column;
    bits[static_cast<std::size_t>(at >> 6)] ^= std::uint64_t{1} << (at & 63);
  };
  const LineCrossings c(a.x - x0, dx, dy, to_first, end - begin);
  if (c.exact) {
    std::int64_t at = c.at + c.before;
    for (std::int64_t row = begin; row < end; ++row, at += c.slope)
      flip(row, (at >> LineCrossings::kBits) + 1);
    return;
  }
  for (std::int64_t row = begin; row < end; ++row) {
    const std::int64_t numerator = (a.x - x0) * dy + (row * kOne - (a.y - y0)) * dx;
    const std::int64_t whole = numerator / (dy * kOne);  // towards zero
    flip(row, whole + (whole * dy * kOne < numerator ? 1 : 0));
  }
}

/// Replaces each bit of a row by the parity of the bits up to it.
inline void running_parity(std::span<std::uint64_t> row) {
  std::uint64_t before = 0;
  for (std::uint64_t& word : row) {
    std::uint64_t w = word;
    for (int by = 1; by < 64; by *= 2) w ^= w << by;
    word = w ^ before;
    before = std::uint64_t{0} - (word >> 63);
  }
}

/// Which beams have a next neighbour in scan direction: at most `gap_rad` further, within the first
/// revolution. `Ray` has `end` and `bearing_rad`.
template <class Ray>
void find_neighbours(std::span<const Ray> rays, const SubCellPoint& origin, double gap_rad,
                     std::vector<std::uint8_t>& has_next) {
  using std::numbers::pi;
  const auto next = [&](std::size_t i) -> const Ray& {
    return rays[i + 1 == rays.size() ? 0 : i + 1];
  };
  const auto bearing_step = [&](std::size_t i) {
    const double step =
        static_cast<double>(next(i).bearing_rad) - static_cast<double>(rays[i].bearing_rad);
    return std::abs(step) < pi ? step : std::remainder(step, 2 * pi);
  };
  double direction = 0.0;
  for (std::size_t i = 0; i + 1 < rays.size(); ++i) direction += bearing_step(i) > 0 ? 1 : -1;
  direction = direction < 0 ? -1 : 1;
  double swept = 0.0;
  has_next.assign(rays.size(), 0);
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const double step = direction * bearing_step(i);
    swept += step < -gap_rad ? step + 2 * pi : step;  // a large step back wraps to a forward one
    const SubCellPoint &a = rays[i].end, &b = next(i).end;
    const double cross = static_cast<double>(a.x - origin.x) * static_cast<double>(b.y - origin.y) -
                         static_cast<double>(a.y - origin.y) * static_cast<double>(b.x - origin.x);
    has_next[i] = step > 0 && step <= gap_rad && swept < 2 * pi + 1e-4 && direction * cross > 0;
  }
}

/// Sets the bits of the cells whose centres are between neighbouring rays. All must be zero before.
template <class Ray>
void fill_polygon(std::span<const Ray> rays, std::span<const std::uint8_t> has_next,
                  const SubCellPoint& origin, const RasterShape& raster, std::int64_t rows,
                  std::span<std::uint64_t> bits) {
  bool before = has_next.back() != 0;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const bool next = has_next[i] != 0;
    // Edges to the sensor between two filled sectors cancel, so they are skipped.
    if (next != before) flip_along_edge(origin, rays[i].end, raster, bits);
    if (next)
      flip_along_edge(rays[i].end, rays[i + 1 == rays.size() ? 0 : i + 1].end, raster, bits);
    before = next;
  }
  const auto words = static_cast<std::size_t>(raster.stride / 64);
  for (std::size_t y = 0; y < static_cast<std::size_t>(rows); ++y)
    running_parity(bits.subspan(y * words, words));
}

}  // namespace wayfare::detail
