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

/// The maximum of each place and those `shift` on, along rows, columns and both: windows twice as
/// wide for a shift by their side, one wider for a shift of 1. What lies past the end counts as
/// zero.
void widen(std::vector<std::uint8_t>& a, int width, int height, int shift,
           std::vector<std::uint8_t>& row) {
  const auto max_into = kernels::best_kernels().max_into;
  row.assign(static_cast<std::size_t>(width) + static_cast<std::size_t>(shift), 0);
  for (int y = 0; y < height; ++y) {
    std::uint8_t* line = a.data() + at(0, y, width);
    std::copy(line, line + width, row.data());
    max_into(line, row.data() + shift, width);
  }
  // Rows upwards: each reads only a row not yet replaced.
  for (int y = 0; y + shift < height; ++y)
    max_into(a.data() + at(0, y, width), a.data() + at(0, y + shift, width), width);
}

/// Entry (R, Q) of plane (q, p) holds units (4Q + p, 4(R + j) + q), j < 4, as four bytes.
void interleave(const std::vector<std::uint8_t>& windows, int width, MaxPyramid::Level& level) {
  const auto interleave_rows = kernels::best_kernels().interleave;
  level.table.resize(at(0, 16 * level.rows, level.columns));
  for (int q = 0; q < 4; ++q)
    for (int r = 0; r < level.rows; ++r) {
      const std::uint8_t* in[4];
      std::uint8_t* out[4];
      for (int j = 0; j < 4; ++j) {
        in[j] = windows.data() + at(0, 4 * (r + j) + q, width);
        out[j] = level.table.data() + at(0, (q * 4 + j) * level.rows + r, level.columns);
      }
      interleave_rows(in, level.columns / 4, out);
    }
}

}  // namespace

void MaxPyramid::keep_pairs(int stride) {
  const int border = MatchGrid::kBorder;
  pairs_.assign(at(0, grid_.height() + 2 * border, grid_.stride()), 0);
  for (int y = -1; y < grid_.height(); ++y)
    std::copy_n(windows_.data() + at(kMargin - 1, y + kMargin, stride), grid_.width() + 1,
                pairs_.data() + at(border - 1, y + border, grid_.stride()));
}

void MaxPyramid::build(MatchGrid grid) {
  const auto sixteenths = kernels::best_kernels().sixteenths;
  grid_ = std::move(grid);
  int width = grid_.width(), height = grid_.height();
  for (int l = 0; l < kLevels; ++l) {
    Level& level = levels_[static_cast<std::size_t>(l)];
    level.width = width;
    level.height = height;
    level.columns = 4 * ((width + kMargin) / 4 + 5);
    level.rows = (height + kMargin) / 4 + 2;
    const int stride = level.columns, padded_height = 4 * (level.rows + 3) + 4;
    windows_.assign(at(0, padded_height, stride), 0);
    for (int y = 0; y < height; ++y) {
      std::uint8_t* line = windows_.data() + at(kMargin, y + kMargin, stride);
      if (l == 0)
        sixteenths(grid_.data() + std::ptrdiff_t{y} * grid_.stride(), width, line);
      else
        std::copy_n(units_.data() + at(0, y, width), width, line);
    }
    widen(windows_, stride, padded_height, 1, row_);
    if (l == 0) keep_pairs(stride);
    widen(windows_, stride, padded_height, 2, row_);
    // Disjoint blocks of 4×4 units are the units of the next level.
    const int next_width = (width + 3) / 4, next_height = (height + 3) / 4;
    units_.resize(at(0, next_height, next_width));
    for (int y = 0; y < next_height; ++y)
      for (int x = 0; x < next_width; ++x)
        units_[at(x, y, next_width)] = windows_[at(4 * x + kMargin, 4 * y + kMargin, stride)];
    if (l > 0) widen(windows_, stride, padded_height, 1, row_);
    interleave(windows_, stride, level);
    width = next_width;
    height = next_height;
  }
}

}  // namespace wayfare
