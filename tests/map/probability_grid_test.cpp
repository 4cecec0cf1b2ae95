#include <wayfare/map/probability_grid.hpp>

#include <gtest/gtest.h>

#include <wayfare/core/random.hpp>

namespace wayfare {
namespace {

OccupancyGrid strewn(Rng& rng, int n) {
  OccupancyGrid grid;
  for (int i = 0; i < n; ++i)
    grid.update({static_cast<int>(rng.below(300)) - 170, static_cast<int>(rng.below(200)) - 30},
                LogOdds::from_nats(rng.uniform(-5, 5)));
  return grid;
}

/// p is rounded to 1/4080.
void expect_equal(const ProbabilityGrid& table, const OccupancyGrid& grid, double unknown) {
  for (int y = -50; y < 190; ++y)
    for (int x = -190; x < 150; ++x) {
      const double want = grid.observed({x, y}) ? grid.probability({x, y}) : unknown;
      ASSERT_NEAR(table.probability({x, y}), want, 0.51 / ProbabilityGrid::kOne) << x << ' ' << y;
    }
}

TEST(ProbabilityGrid, EqualsTheGridsProbability) {
  Rng rng(1);
  const OccupancyGrid grid = strewn(rng, 20000);
  ProbabilityGrid table;
  for (const int margin : {0, 7}) {
    ASSERT_TRUE(table.make(grid, 0.25, margin));
    EXPECT_EQ(table.width(), grid.bounds()->width() + 2 * margin);
    expect_equal(table, grid, 0.25);
  }
}

TEST(ProbabilityGrid, UpdatesTheGivenBoxOnly) {
  Rng rng(2);
  OccupancyGrid grid = strewn(rng, 5000);
  ProbabilityGrid table;
  ASSERT_TRUE(table.make(grid, 0.1));
  const Cell corner = grid.bounds()->min;
  const CellBox box{corner + Cell{20, 11}, corner + Cell{150, 90}};
  for (int y = box.min.y; y <= box.max.y; y += 3)
    for (int x = box.min.x; x <= box.max.x; x += 2) grid.update({x, y}, LogOdds::from_nats(1));
  ASSERT_TRUE(table.update(grid, box));
  expect_equal(table, grid, 0.1);
  const Cell beyond = grid.bounds()->max + Cell{1, 0};
  EXPECT_FALSE(table.update(grid, {beyond, beyond}));
  expect_equal(table, grid, 0.1);
}

TEST(ProbabilityGrid, ReportsInvalidInput) {
  Rng rng(3);
  const OccupancyGrid grid = strewn(rng, 10);
  ProbabilityGrid table;
  EXPECT_FALSE(table.make(OccupancyGrid(), 0.5));
  EXPECT_FALSE(table.make(grid, 1.5));
  EXPECT_FALSE(table.make(grid, 0.5, -1));
  ASSERT_TRUE(table.make(grid, 0.5));
  OccupancyGrid vast;
  vast.update({0, 0}, LogOdds::from_nats(1));
  vast.update({100000, 100000}, LogOdds::from_nats(1));
  EXPECT_FALSE(table.make(vast, 0.5));
  EXPECT_TRUE(table.empty());
  EXPECT_FALSE(table.update(grid, {{0, 0}, {0, 0}}));
}

}  // namespace
}  // namespace wayfare
