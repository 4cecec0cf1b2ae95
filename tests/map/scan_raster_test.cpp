#include <wayfare/map/detail/scan_raster.hpp>

#include <algorithm>
#include <cmath>
#include <map>
#include <span>
#include <vector>

#include <gtest/gtest.h>

#include <wayfare/core/random.hpp>
#include <wayfare/map/cell.hpp>

namespace wayfare {
namespace {

constexpr std::int64_t kOne = std::int64_t{1} << SubCellPoint::kBits;
const ScanUpdate kUpdate{LogOdds{-100}, LogOdds{700}, 0.05};

OccupancyGrid wide_grid() { return OccupancyGrid({1.0, 1e-9, 1.0 - 1e-9}); }

std::vector<ScanRaster::Ray> random_rays(Rng& rng, const SubCellPoint& origin, int count,
                                         double max_range = 60.0) {
  std::vector<ScanRaster::Ray> rays;
  for (int i = 0; i < count; ++i) {
    const double bearing = rng.uniform(-3.1, 3.1), range = rng.uniform(0.5, max_range);
    rays.push_back({{origin.x + std::llround(range * kOne * std::cos(bearing)),
                     origin.y + std::llround(range * kOne * std::sin(bearing))},
                    static_cast<float>(bearing),
                    rng.uniform() < 0.7});
  }
  return rays;
}

/// Cell by cell: freed by each beam that passes it, or once; never if a beam hits it.
template <class FreeSpace>
std::map<Cell, int> by_hand(const std::vector<ScanRaster::Ray>& rays, const SubCellPoint& origin,
                            const ScanUpdate& update = kUpdate) {
  std::map<Cell, int> passes, hits, sum;
  for (const auto& ray : rays) {
    for_each_cell_on_segment(origin, ray.end, [&](const Cell& c) { ++passes[c]; });
    if (ray.hit) ++hits[ray.end.cell()];
  }
  for (const auto& [cell, n] : passes)
    if (!hits.contains(cell))
      sum[cell] = update.free.fixed * std::min(n, FreeSpace::kMaxPassesPerCell);
  for (const auto& [cell, n] : hits)
    sum[cell] = update.hit.fixed * std::min(n, FreeSpace::kMaxPassesPerCell);
  return sum;
}

/// Beams from and to multiples of a unit.
template <class FreeSpace>
void expect_by_hand(std::int64_t unit = 1) {
  const auto rounded = [unit](const SubCellPoint& p) {
    return SubCellPoint{p.x / unit * unit, p.y / unit * unit};
  };
  Rng rng(4);
  ScanRaster raster;  // reused, so that state left by a scan would appear in the next
  for (int round = 0; round < 20; ++round) {
    const SubCellPoint origin = rounded({static_cast<std::int64_t>(rng.below(500'000)) - 250'000,
                                         static_cast<std::int64_t>(rng.below(500'000)) - 250'000});
    OccupancyGrid grid = wide_grid();
    raster.rays() = random_rays(rng, origin, 40);
    for (ScanRaster::Ray& ray : raster.rays()) ray.end = rounded(ray.end);
    const auto want = by_hand<FreeSpace>(raster.rays(), origin);
    ASSERT_TRUE(raster.apply<FreeSpace>(grid, origin, kUpdate));
    std::size_t observed = 0;
    grid.for_each_tile([&](const Cell&, std::span<const std::int16_t> cells) {
      for (const std::int16_t l : cells) observed += l != OccupancyGrid::kUnknown ? 1 : 0;
    });
    EXPECT_EQ(observed, want.size());
    for (const auto& [cell, l] : want)
      ASSERT_EQ(grid.log_odds(cell).fixed, l) << cell.x << ' ' << cell.y;
    CellBox box{want.begin()->first, want.begin()->first};
    for (const auto& [cell, l] : want) box.extend(cell);
    EXPECT_EQ(grid.bounds(), box);
  }
}

TEST(ScanRaster, EqualsTheCellByCellUpdateOfEveryBeam) { expect_by_hand<EveryBeam>(); }
TEST(ScanRaster, EqualsTheCellByCellUpdateOncePerScan) { expect_by_hand<OncePerScan>(); }
TEST(ScanRaster, EqualsTheCellByCellUpdateThroughCorners) {
  for (const std::int64_t parts : {1, 2, 4, 16}) expect_by_hand<EveryBeam>(kOne / parts);
}

struct ThreeTimes {
  static constexpr int kMaxPassesPerCell = 3;
  static constexpr bool kFills = false;
};
TEST(ScanRaster, EqualsTheCellByCellUpdateOfACallersPolicy) { expect_by_hand<ThreeTimes>(); }

/// Clamped after each step, by the definition.
void expect_clamped(const OccupancyGridOptions& options, const ScanUpdate& update, int beams,
                    double max_range) {
  Rng rng(6);
  const SubCellPoint origin{1234, -77777};
  OccupancyGrid grid(options);
  ScanRaster raster;
  std::map<Cell, int> want;
  const int low = LogOdds::from_probability(options.min_probability).fixed;
  const int high = LogOdds::from_probability(options.max_probability).fixed;
  for (int round = 0; round < 3; ++round) {
    raster.rays() = random_rays(rng, origin, beams, max_range);
    for (const auto& [cell, sum] : by_hand<EveryBeam>(raster.rays(), origin, update))
      want[cell] = std::clamp(want[cell] + sum, low, high);
    ASSERT_TRUE(raster.apply<EveryBeam>(grid, origin, update));
  }
  for (const auto& [cell, l] : want)
    ASSERT_EQ(grid.log_odds(cell).fixed, l) << cell.x << ' ' << cell.y;
}

TEST(ScanRaster, ClampsAtTheLimits) {
  expect_clamped({1.0, 0.1, 0.9}, {LogOdds{-400}, LogOdds{3000}, 0.0}, 300, 40.0);
  expect_clamped({1.0, 0.1, 0.9}, {LogOdds{300}, LogOdds{-500}, 0.0}, 300, 40.0);
  // Limits and steps whose sum does not fit 16 bits.
  expect_clamped({1.0, 1e-13, 1 - 1e-13}, {LogOdds{-9000}, LogOdds{32700}, 0.0}, 60, 40.0);
  expect_clamped({1.0, 1e-13, 1 - 1e-13}, {LogOdds{32000}, LogOdds{-9000}, 0.0}, 60, 40.0);
}

TEST(ScanRaster, CountsMoreBeamsThanFit16Bits) {
  expect_clamped({1.0, 1e-9, 1 - 1e-9}, {LogOdds{-1}, LogOdds{1}, 0.0}, 70'000, 9.0);
}

TEST(ScanRaster, FollowsBeamsOfThousandsOfCells) {
  expect_clamped({1.0, 0.1, 0.9}, {LogOdds{-400}, LogOdds{3000}, 0.0}, 12, 2600.0);
}

TEST(ScanRaster, ReportsAScanThatIsTooLargeAndAcceptsTheNext) {
  ScanRaster raster;
  OccupancyGrid grid = wide_grid();
  raster.rays() = {{{20'000 * kOne, 20'000 * kOne}, 0.8F, true}};
  const auto refused = raster.apply<OncePerScan>(grid, {0, 0}, kUpdate);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::invalid);
  EXPECT_FALSE(grid.bounds());
  raster.rays() = {{{3 * kOne, 0}, 0.0F, true}};
  ASSERT_TRUE(raster.apply<OncePerScan>(grid, {0, 0}, kUpdate));
  EXPECT_EQ(grid.log_odds({1, 0}), kUpdate.free);
  EXPECT_EQ(grid.log_odds({3, 0}), kUpdate.hit);
  raster.rays().clear();
  EXPECT_TRUE(raster.apply<OncePerScan>(grid, {0, 0}, kUpdate));
}

TEST(ScanRaster, DoesNotHitIfHitsHaveZeroLogOdds) {
  ScanRaster raster;
  OccupancyGrid grid = wide_grid();
  raster.rays() = {{{3 * kOne, 0}, 0.0F, true}};
  ASSERT_TRUE(raster.apply<OncePerScan>(grid, {0, 0}, {kUpdate.free, LogOdds{0}, 0.0}));
  EXPECT_EQ(grid.log_odds({2, 0}), kUpdate.free);
  EXPECT_FALSE(grid.observed({3, 0}));
}

TEST(ScanRaster, DirectionsAreThoseOfTheCurrentScan) {
  ScanRaster raster;
  LaserScan scan;
  scan.first_bearing = Angle::degrees(-90);
  scan.bearing_step = Angle::degrees(30);
  for (const std::size_t beams : {std::size_t{7}, std::size_t{5}}) {
    scan.ranges_m.assign(beams, 1.0F);
    for (const double step : {30.0, 20.0}) {
      scan.bearing_step = Angle::degrees(step);
      for (int again = 0; again < 2; ++again) {
        const auto& directions = raster.directions(scan);
        ASSERT_EQ(directions.size(), beams);
        for (std::size_t i = 0; i < beams; ++i) {
          const double b = scan.bearing(i).radians();
          EXPECT_EQ(directions[i], Eigen::Vector2d(std::cos(b), std::sin(b)));
        }
      }
    }
  }
}

}  // namespace
}  // namespace wayfare
