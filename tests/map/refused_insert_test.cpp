// Maps that refuse a scan are as if they had never seen it: two maps get the same good scans, one
// of them bad ones in between, and are the same byte for byte.

#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include <wayfare/core/random.hpp>
#include <wayfare/map/likelihood_field.hpp>
#include <wayfare/map/probability_grid.hpp>

#include "match/walls.hpp"

namespace wayfare {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();

using Bytes = std::vector<std::int64_t>;

void append(Bytes& bytes, const OccupancyGrid& grid) {
  bytes.push_back(static_cast<std::int64_t>(grid.tiles().tile_count()));
  if (const auto box = grid.bounds())
    bytes.insert(bytes.end(), {box->min.x, box->min.y, box->max.x, box->max.y});
  grid.for_each_tile([&](const Cell& corner, std::span<const std::int16_t> cells) {
    bytes.insert(bytes.end(), {corner.x, corner.y});
    bytes.insert(bytes.end(), cells.begin(), cells.end());
  });
}

/// With the border.
void append(Bytes& bytes, const PaddedTable& table) {
  bytes.insert(bytes.end(), {table.origin().x, table.origin().y, table.width(), table.height()});
  if (table.empty()) return;
  constexpr int kBorder = PaddedTable::kBorder;
  const std::uint16_t* first = table.data() - std::ptrdiff_t{kBorder} * table.stride() - kBorder;
  bytes.insert(bytes.end(), first,
               first + std::ptrdiff_t{table.stride()} * (table.height() + 2 * kBorder));
}

Bytes bytes_of(const OccupancyGrid& grid) {
  Bytes bytes;
  append(bytes, grid);
  return bytes;
}

Bytes bytes_of(const MultiResolutionGrid& map) {
  Bytes bytes{map.empty(), static_cast<std::int64_t>(map.memory_bytes())};
  append(bytes, map.finest());
  for (const ProbabilityGrid& table : map.tables()) append(bytes, table);
  return bytes;
}

/// One insertion that is to be refused.
template <class Map>
using Bad = std::function<Result<void>(Map&)>;

/// `good(map, k)` is the k-th insertion.
template <class Map>
void expect_untouched(const Map& empty, const std::function<Result<void>(Map&, int)>& good,
                      const std::vector<Bad<Map>>& bad) {
  Map clean = empty, troubled = empty;
  for (int k = 0; k < 6; ++k) {
    for (std::size_t i = 0; i < bad.size(); ++i) {
      // What is too large for its place is too large only once there is something elsewhere.
      if (k == 0 && i + 2 >= bad.size()) continue;
      ASSERT_FALSE(bad[i](troubled)) << "bad insertion " << i << " before good one " << k;
      ASSERT_EQ(bytes_of(troubled), bytes_of(clean)) << "bad insertion " << i;
    }
    ASSERT_TRUE(good(clean, k));
    ASSERT_TRUE(good(troubled, k)) << "after refusals, insertion " << k;
    ASSERT_EQ(bytes_of(troubled), bytes_of(clean)) << "good insertion " << k;
  }
}

const SE2d kNoPoses[] = {SE2d(kNan, 0, Angle{}), SE2d(0, kInf, Angle{}),
                         SE2d(0, 0, Angle::radians(kNan))};
// 1e12 m is beyond the last cell. Last the two that only a map's size refuses: from the origin to
// 1e6 m is 2e7 cells of 5 cm, more than a table has, and to 700 m are 1.4e4 each way, 2e8 in all;
// at four times the cell, 1.2e7, they fit the 2²⁶ = 6.7e7.
const SE2d kFar[] = {SE2d(1e12, 0, Angle{}), SE2d(1e6, 1e6, Angle{}), SE2d(700, 700, Angle{})};

LaserScan scan_at(int k) {
  Rng rng(static_cast<std::uint64_t>(k + 1));
  return Walls::room().scan(SE2d(k - 3.0, 0.3, Angle::degrees(20.0 * k)), rng);
}
SE2d pose_at(int k) { return SE2d(k - 3.0, 0.3, Angle::degrees(20.0 * k)); }

PointSet points_at(int k) { return end_points(scan_at(k), SE2d()); }

PointSet with(PointSet points, float x, float y) {
  points.push_back({x, y});
  return points;
}

/// A thousand kilometres from end to end.
LaserScan endless() {
  LaserScan scan;
  scan.bearing_step = Angle::degrees(45);
  scan.max_range_m = 1e9F;
  scan.ranges_m = {1e6F, 1e6F, 1e6F};
  return scan;
}

constexpr InverseLidarModel kModel{.p_free = 0.4, .p_hit = 0.9, .max_usable_range_m = 2e6};

template <class FreeSpace>
void expect_grid_untouched() {
  ScanRaster raster;  // its memory must not remember what was refused either
  std::vector<Bad<OccupancyGrid>> bad;
  const auto by_scan = [&](const SE2d& pose, const LaserScan& scan, const InverseLidarModel& m) {
    bad.emplace_back([&raster, pose, scan, m](OccupancyGrid& grid) {
      return insert_scan<FreeSpace>(grid, pose, scan, m, raster);
    });
  };
  const auto by_points = [&](const SE2d& pose, const PointSet& points) {
    bad.emplace_back([&raster, pose, points](OccupancyGrid& grid) {
      return insert_points<FreeSpace>(grid, pose, points, kModel, raster);
    });
  };
  for (const SE2d& pose : {kNoPoses[0], kNoPoses[1], kNoPoses[2], kFar[0]}) {
    by_scan(pose, scan_at(1), kModel);
    by_points(pose, points_at(1));
  }
  for (const InverseLidarModel& m :
       {InverseLidarModel{.p_free = 1.2}, InverseLidarModel{.p_hit = kNan},
        InverseLidarModel{.max_usable_range_m = 0.0}})
    by_scan(SE2d(), scan_at(2), m);
  const auto nan = static_cast<float>(kNan), inf = static_cast<float>(kInf);
  for (const float x : {nan, inf, -inf}) by_points(SE2d(), with(points_at(2), 0.0F, x));
  by_points(SE2d(), with(points_at(2), 1e6F, 1e6F));
  by_scan(SE2d(), endless(), kModel);
  by_scan(SE2d(), endless(), kModel);
  expect_untouched<OccupancyGrid>(
      OccupancyGrid(),
      [&](OccupancyGrid& grid, int k) {
        if (k % 2 == 0) return insert_scan<FreeSpace>(grid, pose_at(k), scan_at(k), kModel, raster);
        return insert_points<FreeSpace>(grid, pose_at(k), points_at(k), kModel, raster);
      },
      bad);
}

TEST(RefusedInsert, LeavesAnOccupancyGrid) {
  expect_grid_untouched<OncePerScan>();
  expect_grid_untouched<EveryBeam>();
  expect_grid_untouched<FillBetweenBeams>();
}

TEST(RefusedInsert, LeavesEveryLevelOfAMultiResolutionGrid) {
  std::vector<Bad<MultiResolutionGrid>> bad;
  const auto nan = static_cast<float>(kNan);
  for (const PointSet& points : {with(points_at(2), nan, 0.0F), with(points_at(2), 1e6F, 1e6F)})
    bad.emplace_back([points](MultiResolutionGrid& map) { return map.insert(SE2d(), points); });
  for (const SE2d& pose : kNoPoses) {
    bad.emplace_back([pose](MultiResolutionGrid& map) { return map.insert(pose, scan_at(1)); });
    bad.emplace_back([pose](MultiResolutionGrid& map) { return map.insert(pose, points_at(1)); });
  }
  bad.emplace_back([](MultiResolutionGrid& map) { return map.insert(SE2d(), endless()); });
  bad.emplace_back([](MultiResolutionGrid& map) { return map.insert(kFar[0], scan_at(1)); });
  const std::vector<Bad<MultiResolutionGrid>> always = bad;
  for (const bool by_scan : {true, false}) {
    bad = always;
    for (const SE2d& pose : {kFar[1], kFar[2]})
      bad.emplace_back([pose, by_scan](MultiResolutionGrid& map) {
        return by_scan ? map.insert(pose, scan_at(1)) : map.insert(pose, points_at(1));
      });
    for (const int levels : {1, 3}) {
      MultiResolutionOptions options;
      options.levels = levels;
      options.model = kModel;
      expect_untouched<MultiResolutionGrid>(
          MultiResolutionGrid(options),
          [](MultiResolutionGrid& map, int k) {
            return k % 2 == 0 ? map.insert(pose_at(k), scan_at(k))
                              : map.insert(pose_at(k), points_at(k));
          },
          bad);
    }
  }
}

// Of 2²⁶ = 8192² cells, 32 of border and 5 m = 100 cells to spare on each side leave 8192 − 264 =
// 7928 cells a side of the observed.
TEST(RefusedInsert, ATableTakesWhatFitsItsCells) {
  // One cell alone: a beam without length.
  const auto insert = [](MultiResolutionGrid& map, int cell) {
    const Eigen::Vector2d place = centre_of({cell, cell}, 0.05);
    PointSet points;
    points.push_back(place.cast<float>());
    return map.insert(SE2d(), points, Eigen::Vector2d(points[0].cast<double>()));
  };
  MultiResolutionGrid map;
  ASSERT_TRUE(insert(map, 0));
  const Bytes before = bytes_of(map);
  EXPECT_FALSE(insert(map, 7928));
  EXPECT_EQ(bytes_of(map), before);
  EXPECT_TRUE(insert(map, 7927));
  EXPECT_EQ(map.tables().back().width(), 8128);
}

TEST(RefusedInsert, OptionsThatNoTableCanHaveLeaveTheGridsEmpty) {
  MultiResolutionOptions options;
  options.unknown_probability = 1.5;
  MultiResolutionGrid map(options);
  const Bytes before = bytes_of(map);
  EXPECT_FALSE(map.insert(SE2d(), scan_at(0)));
  EXPECT_EQ(bytes_of(map), before);
}

OccupancyGrid room() {
  OccupancyGrid grid;
  ScanRaster raster;
  for (int k = 0; k < 3; ++k) (void)insert_scan(grid, pose_at(k), scan_at(k), kModel, raster);
  return grid;
}

/// `make(maker, points, pose, view)` with a maker that was refused before, and one that was not.
template <class Maker, class Make>
void expect_maker_untouched(const Make& make) {
  Maker clean, troubled;
  LikelihoodField clean_view, troubled_view;
  const auto nan = static_cast<float>(kNan);
  for (int k = 0; k < 6; ++k) {
    const std::vector<std::pair<PointSet, SE2d>> bad{{PointSet(), SE2d()},
                                                     {with(points_at(k), nan, 0.0F), pose_at(k)},
                                                     {with(points_at(k), 1e6F, 1e6F), pose_at(k)},
                                                     {points_at(k), kNoPoses[k % 3]}};
    for (const auto& [points, pose] : bad) {
      ASSERT_FALSE(make(troubled, points, pose, troubled_view));
      ASSERT_TRUE(troubled_view.empty());
    }
    ASSERT_TRUE(make(clean, points_at(k), pose_at(k), clean_view));
    ASSERT_TRUE(make(troubled, points_at(k), pose_at(k), troubled_view));
    Bytes a, b;
    append(a, clean_view);
    append(b, troubled_view);
    ASSERT_EQ(a, b);
    ASSERT_EQ(clean_view.log_floor(), troubled_view.log_floor());
    ASSERT_EQ(clean_view.log_step(), troubled_view.log_step());
  }
}

TEST(RefusedInsert, LeavesMakersOfFields) {
  const OccupancyGrid grid = room();
  expect_maker_untouched<OccupancyFieldMaker>(
      [&](auto& maker, const PointSet& points, const SE2d& pose, LikelihoodField& view) {
        return maker.make(grid, points, pose, {}, {}, view);
      });
  const DetectionViewOptions detections{.hit_probability = 0.7, .max_detections = 30.0};
  expect_maker_untouched<DetectionFieldMaker>(
      [&](auto& maker, const PointSet& points, const SE2d& pose, LikelihoodField& view) {
        return maker.make(grid, points, pose, {}, detections, view);
      });
  expect_maker_untouched<LikelihoodFieldMaker>(
      [&](auto& maker, const PointSet& points, const SE2d& pose, LikelihoodField& view) {
        const PlacedPoints placed{&points, pose};
        return maker.make(std::span(&placed, 1), {}, view);
      });
}

// What a grid no longer has it does not bound: it is as a new one, whoever has its cells now.
TEST(MovedFrom, AGridIsEmpty) {
  OccupancyGrid grid = room(), fresh;
  const Bytes before = bytes_of(grid);
  const OccupancyGrid taken = std::move(grid);
  EXPECT_EQ(bytes_of(taken), before);
  EXPECT_EQ(bytes_of(grid), bytes_of(fresh));  // NOLINT(bugprone-use-after-move)
  EXPECT_FALSE(grid.bounds());
  ScanRaster raster;
  for (OccupancyGrid* each : {&grid, &fresh})
    ASSERT_TRUE(insert_scan(*each, pose_at(4), scan_at(4), kModel, raster));
  EXPECT_EQ(bytes_of(grid), bytes_of(fresh));
  OccupancyGrid assigned = room();
  assigned = std::move(grid);
  EXPECT_EQ(bytes_of(assigned), bytes_of(fresh));
  // NOLINTNEXTLINE(bugprone-use-after-move): what the test is about
  EXPECT_EQ(grid.tiles().tile_count(), 0U);
}

TEST(MovedFrom, ATableIsEmpty) {
  ProbabilityGrid table;
  ASSERT_TRUE(table.make(room(), 0.5));
  Bytes before, after;
  append(before, table);
  const ProbabilityGrid taken = std::move(table);
  append(after, taken);
  EXPECT_EQ(after, before);
  EXPECT_TRUE(table.empty());  // NOLINT(bugprone-use-after-move)
  ASSERT_TRUE(table.make(room(), 0.5));
  after.clear();
  append(after, table);
  EXPECT_EQ(after, before);
}

}  // namespace
}  // namespace wayfare
