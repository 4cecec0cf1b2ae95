#include <wayfare/map/cell.hpp>

#include <algorithm>
#include <set>
#include <vector>

#include <gtest/gtest.h>

#include <wayfare/core/random.hpp>

#include "map/raster.hpp"

namespace wayfare {
namespace {

/// Whether a piece of the segment of positive length lies in half-open cell c: t ∈ [0, 1] clipped
/// to the square in exact fractions.
bool holds_a_piece(const SubCellPoint& a, const SubCellPoint& b, const Cell& c) {
  std::int64_t low = 0, low_den = 1, high = 1, high_den = 1;
  const auto clip = [&](std::int64_t p, std::int64_t d, std::int64_t lo) {
    const std::int64_t hi = lo + (1 << SubCellPoint::kBits), den = std::abs(d);
    if (d == 0) return p >= lo && p < hi;
    const std::int64_t in = d > 0 ? lo - p : p - hi, out = d > 0 ? hi - p : p - lo;
    if (in * low_den > low * den) low = in, low_den = den;
    if (out * high_den < high * den) high = out, high_den = den;
    return true;
  };
  return clip(a.x, b.x - a.x, std::int64_t{c.x} << SubCellPoint::kBits) &&
         clip(a.y, b.y - a.y, std::int64_t{c.y} << SubCellPoint::kBits) &&
         low * high_den < high * low_den;
}

void expect_exact(const SubCellPoint& a, const SubCellPoint& b) {
  std::vector<Cell> cells;
  for_each_cell_on_segment(a, b, [&](const Cell& c) { cells.push_back(c); });
  const Cell from = a.cell(), to = b.cell();
  EXPECT_EQ(cells.front(), from);
  EXPECT_EQ(cells.back(), to);
  for (std::size_t i = 1; i < cells.size(); ++i) {
    const Cell d = cells[i] - cells[i - 1];
    EXPECT_EQ(std::max(std::abs(d.x), std::abs(d.y)), 1);
  }
  for (int y = std::min(from.y, to.y) - 1; y <= std::max(from.y, to.y) + 1; ++y)
    for (int x = std::min(from.x, to.x) - 1; x <= std::max(from.x, to.x) + 1; ++x) {
      const Cell c{x, y};
      const bool want = c == from || c == to || holds_a_piece(a, b, c);
      EXPECT_EQ(std::count(cells.begin(), cells.end(), c), want ? 1 : 0)
          << a.x << ',' << a.y << " to " << b.x << ',' << b.y << " at " << x << ',' << y;
    }
}

TEST(Ray, VisitsExactlyTheCellsOfRandomSegments) {
  Rng rng(1);
  const auto any = [&] { return static_cast<std::int64_t>(rng.below(80000)) - 40000; };
  for (int i = 0; i < 2000; ++i) expect_exact({any(), any()}, {any(), any()});
}

TEST(Ray, GoesThroughCornersAndAlongLines) {
  // Ends on quarter cells, so that corners, boundaries and axis-parallel segments are frequent.
  Rng rng(2);
  const auto any = [&] { return (static_cast<std::int64_t>(rng.below(33)) - 16) * 1024; };
  for (int i = 0; i < 5000; ++i) expect_exact({any(), any()}, {any(), any()});
}

/// How often each cell of a raster is passed, from the differences.
template <class Count>
void expect_the_same_cells(const SubCellPoint& a, const SubCellPoint& b,
                           PassDifferences<Count>& differences) {
  const Cell low{std::min(a.cell().x, b.cell().x), std::min(a.cell().y, b.cell().y)};
  const Cell high{std::max(a.cell().x, b.cell().x), std::max(a.cell().y, b.cell().y)};
  const RasterShape raster{low - Cell{3, 5}, high.x - low.x + 9};
  const auto rows = static_cast<std::size_t>(high.y - low.y + 8);
  const auto stride = static_cast<std::size_t>(raster.stride);
  differences.along_rows.assign(stride * rows, 0);
  differences.along_columns.assign(stride * rows, 0);
  const ScanRaster::Ray ray{b};
  detail::add_segments(a, std::span(&ray, 1), raster, differences);
  std::set<Cell> want, got;
  for_each_cell_on_segment(a, b, [&](const Cell& c) { want.insert(c); });
  std::vector<int> column(stride, 0);
  for (std::size_t y = 0; y < rows; ++y) {
    int row = 0;
    for (std::size_t x = 0; x < stride; ++x) {
      row += differences.along_rows[y * stride + x];
      column[x] += differences.along_columns[y * stride + x];
      const int passes = row + column[x];
      ASSERT_TRUE(passes == 0 || passes == 1);
      if (passes == 1) got.insert(raster.origin + Cell{static_cast<int>(x), static_cast<int>(y)});
    }
  }
  ASSERT_EQ(got, want) << a.x << ',' << a.y << " to " << b.x << ',' << b.y;
}

TEST(AddSegments, CountsTheCellsOfTheSegmentOnce) {
  Rng rng(4);
  // Short ones on corners and boundaries, medium ones, the longest in fixed point, and longer.
  struct Kind {
    int reach, unit, times;
  };
  const Kind kinds[] = {{16, 1024, 1500}, {300, 1024, 1500},  {400'000, 1, 500},
                        {300, 4096, 500}, {3'900'000, 1, 60}, {12'000'000, 1, 15}};
  PassDifferences<std::int16_t> narrow;
  PassDifferences<std::int32_t> wide;
  for (const auto& [reach, unit, times] : kinds) {
    const auto any = [&, r = reach, u = unit] {
      return (static_cast<std::int64_t>(rng.below(2 * r + 1)) - r) * u;
    };
    for (int i = 0; i < times; ++i) {
      const SubCellPoint a{any(), any()};
      SubCellPoint b{any(), any()};
      if (i % 10 == 0) b.x = a.x;
      if (i % 10 == 1) b.y = a.y;
      if (i % 10 == 2) b.y = a.y + std::abs(b.x - a.x);
      expect_the_same_cells(a, b, narrow);
      if (i % 10 == 3) expect_the_same_cells(a, b, wide);
    }
  }
}

TEST(Ray, CellsOfItsEndsAreThoseOfThePoints) {
  Rng rng(3);
  for (int i = 0; i < 1000; ++i) {
    const Eigen::Vector2d p(rng.uniform(-500, 500), rng.uniform(-500, 500));
    EXPECT_EQ(SubCellPoint::of(p, 0.05).cell(), cell_of(p, 0.05));
  }
  EXPECT_EQ(cell_of({NAN, 1e300}, 0.05), (Cell{-kMaxCell, kMaxCell}));
}

}  // namespace
}  // namespace wayfare
