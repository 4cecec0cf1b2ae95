#include <wayfare/map/max_pyramid.hpp>

#include <algorithm>
#include <utility>

#include "kernels/kernels.hpp"

namespace wayfare {
namespace {

constexpr int kMargin = 20;  // units kept on the low side; see bound_index

std::size_t at(int x, int y, int width) {
  return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
         static_cast<std::size_t>(x);
}

/// Maxima of `span` (4 or 5) neighbours from each place on, along rows and then columns; what lies
/// past the end counts as zero.
void window_maxima(std::vector<std::uint8_t>& a, int width, int height, int span,
                   std::vector<std::uint8_t>& row) {
  const auto max_bytes = kernels::best_kernels().max_bytes;
  row.assign(static_cast<std::size_t>(2 * (width + 8)), 0);
  std::uint8_t* one = row.data();
  std::uint8_t* two = one + width + 8;
  for (int y = 0; y < height; ++y) {
    std::uint8_t* line = a.data() + at(0, y, width);
    std::copy(line, line + width, one);
    max_bytes(one, one + 1, width + 3, two);
    max_bytes(two, two + 2, width, line);
    if (span == 5) {
      std::copy(line, line + width, two);
      max_bytes(two, one + 4, width, line);
    }
  }
  // Rows upwards: each reads only rows not yet replaced.
  const auto fold = [&](int y, int other) {
    if (other < height)
      max_bytes(a.data() + at(0, y, width), a.data() + at(0, other, width), width,
                a.data() + at(0, y, width));
  };
  for (int y = 0; y < height; ++y)
    for (int i = 1; i < span; ++i) fold(y, y + i);
}

/// Entry (R, Q) of plane (q, p) holds units (4Q + p, 4(R + j) + q), j < 4, as four bytes.
void interleave(const std::vector<std::uint8_t>& windows, int width, MaxPyramid::Level& level) {
  const int entries = level.columns / 4;
  for (int q = 0; q < 4; ++q)
    for (int r = 0; r < level.rows; ++r) {
      const std::uint8_t* in[4];
      for (int j = 0; j < 4; ++j) in[j] = windows.data() + at(0, 4 * (r + j) + q, width);
      for (int p = 0; p < 4; ++p) {
        std::uint8_t* out = level.table.data() + at(0, (q * 4 + p) * level.rows + r, level.columns);
        for (int e = 0; e < entries; ++e)
          for (int j = 0; j < 4; ++j) out[4 * e + j] = in[j][4 * e + p];
      }
    }
}

}  // namespace

void MaxPyramid::build(MatchGrid grid) {
  grid_ = std::move(grid);
  int width = grid_.width(), height = grid_.height();
  std::vector<std::uint8_t> blocks(static_cast<std::size_t>(width) *
                                   static_cast<std::size_t>(height));
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      blocks[at(x, y, width)] = static_cast<std::uint8_t>(
          (grid_.data()[std::ptrdiff_t{y} * grid_.stride() + x] + 15) >> 4);
  for (int l = 0; l < kLevels; ++l) {
    Level& level = levels_[static_cast<std::size_t>(l)];
    level.width = width;
    level.height = height;
    const int entries = (width + kMargin) / 4 + 5;
    level.columns = 4 * entries;
    level.rows = (height + kMargin) / 4 + 2;
    const int padded_width = 4 * entries, padded_height = 4 * (level.rows + 3) + 4;
    windows_.assign(at(0, padded_height, padded_width), 0);
    for (int y = 0; y < height; ++y)
      std::copy_n(blocks.data() + at(0, y, width), width,
                  windows_.data() + at(kMargin, y + kMargin, padded_width));
    units_ = windows_;
    window_maxima(windows_, padded_width, padded_height, l == 0 ? 4 : 5, row_);
    level.table.resize(at(0, 16 * level.rows, level.columns));
    interleave(windows_, padded_width, level);
    // Disjoint blocks of 4×4 units are the units of the next level.
    const int next_width = (width + 3) / 4, next_height = (height + 3) / 4;
    if (l > 0) window_maxima(units_, padded_width, padded_height, 4, row_);
    const auto& source = l == 0 ? windows_ : units_;
    blocks.resize(at(0, next_height, next_width));
    for (int y = 0; y < next_height; ++y)
      for (int x = 0; x < next_width; ++x)
        blocks[at(x, y, next_width)] = source[at(4 * x + kMargin, 4 * y + kMargin, padded_width)];
    width = next_width;
    height = next_height;
  }
}

}  // namespace wayfare
