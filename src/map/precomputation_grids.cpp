#include <wayfare/map/detail/precomputation_grids.hpp>

#include <algorithm>
#include <utility>

#include "map/kernels/kernels.hpp"

namespace wayfare {
namespace {

using kernels::kBoundMarginX;
using kernels::kBoundMarginY;

constexpr std::size_t kPastEnd = 64;  // zeros, read past the last row

std::size_t at(int x, int y, int width) {
  return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
         static_cast<std::size_t>(x);
}

/// Replaces each entry by the maximum of it and those `shift` further along rows, columns and both.
/// A shift by the window's side doubles the window, a shift of 1 widens it by 1. Entries past the
/// end count as zero.
void widen(std::vector<std::uint8_t>& a, int width, int height, int shift,
           std::vector<std::uint8_t>& row) {
  const auto max_into = kernels::best_kernels().max_into;
  row.assign(static_cast<std::size_t>(width) + static_cast<std::size_t>(shift), 0);
  for (int y = 0; y < height; ++y) {
    std::uint8_t* line = a.data() + at(0, y, width);
    std::copy(line, line + width, row.data());
    max_into(line, row.data() + shift, width);
  }
  // In increasing order, so that each row reads one that is not yet replaced.
  for (int y = 0; y + shift < height; ++y)
    max_into(a.data() + at(0, y, width), a.data() + at(0, y + shift, width), width);
}

/// Row 4y + p stores for each Q the units (4Q + p, y + 4j), j < 4, as four bytes, so that
/// neighbouring candidates read few pages.
void interleave(const std::vector<std::uint8_t>& windows, int width,
                PrecomputationGrids::Level& level) {
  const auto interleave_rows = kernels::best_kernels().interleave;
  const std::size_t size = at(0, 16 * level.rows, level.columns);
  level.table.resize(size + kPastEnd);
  std::fill_n(level.table.data() + size, kPastEnd, std::uint8_t{0});
  for (int y = 0; y < 4 * level.rows; ++y) {
    const std::uint8_t* in[4];
    std::uint8_t* out[4];
    for (int j = 0; j < 4; ++j) {
      in[j] = windows.data() + at(0, y + 4 * j, width);
      out[j] = level.table.data() + at(0, 4 * y + j, level.columns);
    }
    interleave_rows(in, level.columns / 4, out);
  }
}

}  // namespace

void PrecomputationGrids::store_pairs(int stride) {
  const int border = LikelihoodField::kBorder;
  pairs_.assign(at(0, grid_.height() + 2 * border, grid_.stride()), 0);
  for (int y = -1; y < grid_.height(); ++y)
    std::copy_n(windows_.data() + at(kBoundMarginX - 1, y + kBoundMarginY, stride),
                grid_.width() + 1, pairs_.data() + at(border - 1, y + border, grid_.stride()));
}

void PrecomputationGrids::build(LikelihoodField grid) {
  const auto sixteenths = kernels::best_kernels().sixteenths;
  grid_ = std::move(grid);
  int width = grid_.width(), height = grid_.height();
  for (int l = 0; l < kLevels; ++l) {
    Level& level = levels_[static_cast<std::size_t>(l)];
    level.width = width;
    level.height = height;
    // The end of a row is followed by the margin of the next.
    level.columns = 4 * ((width + kBoundMarginX) / 4 + 1);
    level.rows = (height + kBoundMarginY) / 4 + 2;
    const int stride = level.columns, padded_height = 4 * (level.rows + 3) + 4;
    windows_.assign(at(0, padded_height, stride), 0);
    for (int y = 0; y < height; ++y) {
      std::uint8_t* line = windows_.data() + at(kBoundMarginX, y + kBoundMarginY, stride);
      if (l == 0)
        sixteenths(grid_.data() + std::ptrdiff_t{y} * grid_.stride(), width, line);
      else
        std::copy_n(units_.data() + at(0, y, width), width, line);
    }
    widen(windows_, stride, padded_height, 1, row_);
    if (l == 0) store_pairs(stride);
    widen(windows_, stride, padded_height, 2, row_);
    // Disjoint blocks of 4×4 units are the units of the next level.
    const int next_width = (width + 3) / 4, next_height = (height + 3) / 4;
    units_.resize(at(0, next_height, next_width));
    for (int y = 0; y < next_height; ++y)
      for (int x = 0; x < next_width; ++x)
        units_[at(x, y, next_width)] =
            windows_[at(4 * x + kBoundMarginX, 4 * y + kBoundMarginY, stride)];
    if (l > 0) widen(windows_, stride, padded_height, 1, row_);
    interleave(windows_, stride, level);
    width = next_width;
    height = next_height;
  }
}

}  // namespace wayfare
