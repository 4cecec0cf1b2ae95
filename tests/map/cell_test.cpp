#include <wayfare/map/cell.hpp>

#include <limits>

#include <gtest/gtest.h>

namespace wayfare {
namespace {

TEST(Cell, ContainsItsLowerEdgesOnly) {
  EXPECT_EQ(cell_of({0.0, 0.0}, 0.5), (Cell{0, 0}));
  EXPECT_EQ(cell_of({0.49, -0.01}, 0.5), (Cell{0, -1}));
  EXPECT_EQ(cell_of({0.5, -0.5}, 0.5), (Cell{1, -1}));
  EXPECT_EQ(cell_of(centre_of({-7, 9}, 0.05), 0.05), (Cell{-7, 9}));
}

// Sums and differences of two such coordinates must fit an int.
TEST(Cell, LargeCoordinatesSaturate) {
  constexpr double kInf = std::numeric_limits<double>::infinity();
  EXPECT_EQ(cell_coordinate(1e300, 0.05), kMaxCell);
  EXPECT_EQ(cell_coordinate(kInf, 0.05), kMaxCell);
  EXPECT_EQ(cell_coordinate(-1e300, 0.05), -kMaxCell);
  EXPECT_EQ(cell_coordinate(-kInf, 0.05), -kMaxCell);
  EXPECT_EQ(cell_coordinate(std::numeric_limits<double>::quiet_NaN(), 0.05), -kMaxCell);
  const Cell far{kMaxCell, kMaxCell};
  EXPECT_EQ((far - Cell{-kMaxCell, 0}).x, 2 * kMaxCell);
}

TEST(CellBox, CountsBothCornersAndExtends) {
  CellBox box{{-2, 1}, {-2, 1}};
  EXPECT_EQ(box.width() * box.height(), 1);
  box.extend({3, -1});
  EXPECT_EQ(box.width(), 6);
  EXPECT_EQ(box.height(), 3);
  EXPECT_TRUE(box.contains({0, 0}));
  EXPECT_FALSE(box.contains({0, 2}));
  EXPECT_EQ((CellBox{{-kMaxCell, 0}, {kMaxCell, 0}}.width()), std::int64_t{2} * kMaxCell + 1);
}

}  // namespace
}  // namespace wayfare
