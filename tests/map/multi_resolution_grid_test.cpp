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
