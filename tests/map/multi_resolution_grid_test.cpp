#include <wayfare/map/probability_grid.hpp>

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "match/walls.hpp"

namespace wayfare {
namespace {

/// The tables equal tables built from the grids, however they were updated.
TEST(MultiResolutionGrid, TablesEqualTheGrids) {
  Rng rng(8);
  const Walls room = Walls::room();
  MultiResolutionOptions options;
  options.levels = 3;
  MultiResolutionGrid map(options);
  OccupancyGrid alone(options.finest);
  ScanRaster raster;
  // Across the room, then through a wall and far away: the tables must grow twice.
  for (const double x : {-4.0, -2.0, 0.0, 2.0, 4.0, 30.0, -40.0}) {
    const SE2d pose(x, 0.3, Angle::degrees(10 * x));
    LaserScan scan = room.scan(SE2d(std::clamp(x, -4.0, 4.0), 0.3, pose.heading()), rng);
    ASSERT_TRUE(map.insert(pose, scan));
    ASSERT_TRUE(insert_scan(alone, pose, scan, options.model, raster));
  }
  ASSERT_EQ(map.tables().size(), 3U);
  EXPECT_DOUBLE_EQ(map.tables().front().resolution_m(), 4 * options.finest.resolution_m);
  EXPECT_EQ(map.finest().bounds(), alone.bounds());
  ProbabilityGrid fresh;
  ASSERT_TRUE(fresh.make(alone, options.unknown_probability));
  const CellBox box = *alone.bounds();
  for (int y = box.min.y - 3; y <= box.max.y + 3; ++y)
    for (int x = box.min.x - 3; x <= box.max.x + 3; ++x)
      ASSERT_EQ(map.tables().back().value({x, y}), fresh.value({x, y})) << x << ' ' << y;
}

/// Tables of limited reach equal the grids' wherever a scan or `focus` was last, and are no larger.
TEST(MultiResolutionGrid, TablesOfLimitedReachEqualTheGridsNearby) {
  Rng rng(10);
  MultiResolutionOptions options;
  options.levels = 2;
  options.finest.resolution_m = 0.1;
  options.table_reach_m = 12.0;
  constexpr int kReach = 120, kSpare = 50;  // cells of 0.1 m: 12 m, and the 5 m of a table moved
  MultiResolutionGrid map(options);
  const Walls room = Walls::room();
  const auto expect_near = [&](const Eigen::Vector2d& place) {
    const ProbabilityGrid& table = map.tables().back();
    ProbabilityGrid all;
    ASSERT_TRUE(all.make(map.finest(), options.unknown_probability));
    const Cell at = cell_of(place, 0.1);
    for (int y = at.y - kReach; y <= at.y + kReach; ++y)
      for (int x = at.x - kReach; x <= at.x + kReach; ++x)
        ASSERT_EQ(table.value({x, y}), all.value({x, y})) << x << ' ' << y;
    EXPECT_LE(table.width(), 2 * (kReach + kSpare) + 1);
    EXPECT_LE(table.height(), 2 * (kReach + kSpare) + 1);
  };
  for (const double x : {0.0, 2.0, 9.0, 30.0, 28.0, -60.0, 0.0}) {
    const SE2d pose(x, 0.5 * x, Angle());
    ASSERT_TRUE(map.insert(pose, room.scan(SE2d(), rng)));
    expect_near(pose.translation());
    for (int k = 0; k < 5; ++k) {
      const Eigen::Vector2d place(rng.uniform(-70.0, 40.0), rng.uniform(-40.0, 20.0));
      ASSERT_TRUE(map.focus(place));
      expect_near(place);
    }
    ASSERT_TRUE(map.focus(pose.translation()));
    expect_near(pose.translation());
  }
}

TEST(MultiResolutionGrid, ReportsAPoseThatIsNotFinite) {
  Rng rng(9);
  MultiResolutionGrid map;
  const LaserScan scan = Walls::room().scan(SE2d(), rng);
  const SE2d nowhere(std::numeric_limits<double>::quiet_NaN(), 0, Angle());
  EXPECT_FALSE(map.insert(nowhere, scan));
  EXPECT_TRUE(map.empty());
  EXPECT_TRUE(map.insert(SE2d(), scan));
}

}  // namespace
}  // namespace wayfare
