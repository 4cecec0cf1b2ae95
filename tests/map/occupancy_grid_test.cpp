#include <wayfare/map/occupancy_grid.hpp>

#include <cmath>
#include <map>

#include <gtest/gtest.h>

#include <wayfare/core/random.hpp>
#include <wayfare/map/inverse_lidar.hpp>

namespace wayfare {
namespace {

TEST(OccupancyGrid, AddsAndClamps) {
  OccupancyGrid grid;
  const Cell c{-5, 7};
  EXPECT_FALSE(grid.observed(c));
  EXPECT_EQ(grid.probability(c), 0.5);
  const LogOdds hit = LogOdds::from_probability(0.9);
  grid.update(c, hit);
  EXPECT_EQ(grid.log_odds(c), hit);
  for (int i = 0; i < 1000; ++i) grid.update(c, hit);
  EXPECT_NEAR(grid.probability(c), 0.98, 1e-4);
  for (int i = 0; i < 1000; ++i) grid.update(c, LogOdds::from_probability(0.2));
  EXPECT_NEAR(grid.probability(c), 0.02, 1e-4);
}

TEST(OccupancyGrid, GrowsInEveryDirectionAndKeepsItsCells) {
  Rng rng(6);
  OccupancyGrid grid;
  std::map<Cell, int> want;
  for (int i = 0; i < 20000; ++i) {
    const int reach = i % 100 == 0 ? 1'000'000 : 300;  // far tiles too
    const auto any = [&] { return static_cast<int>(rng.uniform(-reach, reach)); };
    const Cell c{any(), any()};
    const LogOdds d{static_cast<std::int16_t>(rng.uniform(-50, 50))};
    grid.update(c, d);
    want[c] += d.fixed;
  }
  for (const auto& [cell, sum] : want) ASSERT_EQ(grid.log_odds(cell).fixed, sum);
  std::size_t observed = 0;
  grid.for_each_tile([&](const Cell& first, std::span<const std::int16_t> cells) {
    for (std::size_t i = 0; i < cells.size(); ++i) {
      if (cells[i] == OccupancyGrid::kUnknown) continue;
      ++observed;
      ASSERT_TRUE(want.contains(first + Cell{static_cast<int>(i % 64), static_cast<int>(i / 64)}));
    }
  });
  EXPECT_EQ(observed, want.size());
}

TEST(OccupancyGrid, CopiesShareTilesUntilOneWrites) {
  OccupancyGrid a;
  const LogOdds hit = LogOdds::from_probability(0.9);
  a.update({1, 1}, hit);
  a.update({100, 1}, hit);
  OccupancyGrid b = a;
  EXPECT_EQ(a.tiles().find({0, 0}), b.tiles().find({0, 0}));
  b.update({2, 2}, hit);
  EXPECT_NE(a.tiles().find({0, 0}), b.tiles().find({0, 0}));
  EXPECT_EQ(a.tiles().find({1, 0}), b.tiles().find({1, 0}));
  EXPECT_FALSE(a.observed({2, 2}));
  a.update({1, 1}, hit);
  EXPECT_EQ(b.log_odds({1, 1}), hit);
}

LaserScan fan() {
  LaserScan scan;
  scan.first_bearing = Angle::degrees(-60);
  scan.bearing_step = Angle::degrees(0.5);
  scan.max_range_m = 30;
  scan.ranges_m.assign(241, 4.0F);
  for (std::size_t i = 100; i < 140; ++i) scan.ranges_m[i] = 2.0F;
  scan.ranges_m[5] = NAN;
  scan.ranges_m[6] = 81.0F;
  scan.ranges_m[7] = -1.0F;
  return scan;
}

/// The model by definition, ray by ray, on a map from cells to counts.
template <class FreeSpace>
void expect_model(const SE2d& pose) {
  const LaserScan scan = fan();
  OccupancyGrid grid({0.05, 0.001, 0.999});
  ScanRaster raster;
  ASSERT_TRUE(insert_scan<FreeSpace>(grid, pose, scan, {}, raster));
  std::map<Cell, int> passes, hits;
  for (std::size_t i = 0; i < scan.ranges_m.size(); ++i) {
    if (!scan.returned(i)) continue;
    const double b = scan.bearing(i).radians(), r = static_cast<double>(scan.ranges_m[i]);
    const Eigen::Vector2d end = pose * Eigen::Vector2d(r * std::cos(b), r * std::sin(b));
    ++hits[cell_of(end, 0.05)];
    for_each_cell_on_segment(pose.translation(), end, 0.05, [&](const Cell& c) { ++passes[c]; });
  }
  const int high = LogOdds::from_probability(0.999).fixed;
  for (const auto& [cell, count] : passes) {
    const bool hit = hits.contains(cell);
    const int n = std::min(hit ? hits[cell] : count, FreeSpace::kMaxPassesPerCell);
    const int delta = n * LogOdds::from_probability(hit ? 0.9 : 0.2).fixed;
    ASSERT_EQ(grid.log_odds(cell).fixed, std::clamp(delta, -high, high));
  }
  std::size_t observed = 0;
  grid.for_each_tile([&](const Cell&, std::span<const std::int16_t> cells) {
    for (const auto l : cells) observed += l != OccupancyGrid::kUnknown;
  });
  EXPECT_EQ(observed, passes.size());
}

TEST(InsertScan, FollowsTheModelOncePerScan) {
  expect_model<OncePerScan>(SE2d(-1.3, 0.4, Angle::degrees(200)));
}
TEST(InsertScan, FollowsTheModelForEveryBeam) {
  expect_model<EveryBeam>(SE2d(12.01, -7.77, Angle::degrees(-31)));
}

TEST(InsertScan, ReportsBadInputAndLeavesTheGridUnchanged) {
  OccupancyGrid grid;
  ScanRaster raster;
  EXPECT_FALSE(insert_scan(grid, SE2d(NAN, 0, Angle()), fan(), {}, raster));
  EXPECT_FALSE(insert_scan(grid, SE2d(), fan(), {1.2, 0.9, 3.0, 0.0}, raster));
  LaserScan endless;
  endless.bearing_step = Angle::degrees(45);
  endless.max_range_m = 1e9F;
  endless.ranges_m = {1e8F, 1e8F, 1e8F};
  EXPECT_FALSE(insert_scan(grid, SE2d(), endless, {0.2, 0.9, 1e9, 0.0}, raster));
  PointSet points;
  points.push_back({NAN, 0.0F});
  EXPECT_FALSE(insert_points(grid, SE2d(), points, {}, raster));
  EXPECT_TRUE(insert_scan(grid, SE2d(), LaserScan{}, {}, raster));
  EXPECT_FALSE(grid.bounds());
}

}  // namespace
}  // namespace wayfare
