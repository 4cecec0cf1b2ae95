#pragma once

// Fills the polygons of the sensor and the ends of neighbouring beams in a raster, by the parity of
// the number of edges left of a cell's centre.

#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <numbers>
#include <span>
#include <utility>
#include <vector>

#include <wayfare/map/detail/raster_walk.hpp>

namespace wayfare::detail {

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

}  // namespace wayfare::detail
