// What grids, their fields and rays do with input and options at the border of what they take.

#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "abuse/abuse.hpp"
#include "abuse/map_cases.hpp"

namespace wayfare::tests {
namespace {

/// Fields of a grid of the room, one of nothing, and one with cells 1e9 apart.
struct Grids {
  OccupancyGrid room = room_grid(), empty, sparse;
  Grids() {
    sparse.update({-kMaxCell + 1, -kMaxCell + 1}, LogOdds::from_nats(2.0));
    sparse.update({kMaxCell - 1, kMaxCell - 1}, LogOdds::from_nats(2.0));
  }
};

TEST(MapFields, GridsThatAreEmptyOrTooLargeHaveNoTables) {
  const Grids g;
  EXPECT_EQ(g.sparse.bounds()->cells(), std::int64_t{kMaxCell} * kMaxCell * 4 - kMaxCell * 4LL + 1);
  EXPECT_TRUE(g.sparse.observed({kMaxCell - 1, kMaxCell - 1}));
  for (const OccupancyGrid* grid : {&g.empty, &g.sparse}) {
    expect_refused(likelihood_field(*grid), "probabilities");
    expect_refused(detection_grid(*grid), "detections");
    expect_refused(DistanceField::of_grid(*grid), "distances");
    ProbabilityGrid table = make<ProbabilityGrid>(2);
    expect_refused(table.make(*grid, 0.5), "table");
    EXPECT_TRUE(table.empty());
  }
}

TEST(MapFields, OptionsOfFieldsOfGrids) {
  const OccupancyGrid grid = room_grid();
  for (const double bad : {kNan, kInf, -kInf, -0.1, 1.5, 1e9}) {
    SCOPED_TRACE(bad);
    expect_refused(likelihood_field(grid, {.floor_probability = bad}), "floor");
    expect_refused(likelihood_field(grid, {.unknown_probability = bad}), "unknown");
    if (bad != 1.5) expect_refused(likelihood_field(grid, {.blur_sigma_m = bad}), "");
    expect_refused(DistanceField::of_grid(grid, bad), "probability");
    ProbabilityGrid table;
    expect_refused(table.make(grid, bad), "unknown");
    expect_refused(detection_grid(grid, {.hit_probability = bad}), "hit");
    if (!(bad > 0)) expect_refused(detection_grid(grid, {.background = bad}), "background");
    if (!(bad >= 0 && bad < 2)) expect_refused(detection_grid(grid, {.blur_sigma_m = bad}), "blur");
  }
  for (const int margin :
       {-1, std::numeric_limits<int>::min(), kMaxCell, std::numeric_limits<int>::max()}) {
    ProbabilityGrid table;
    expect_refused(table.make(grid, 0.5, margin), "margin");
  }
  // One half says nothing about the cell, and neither does what rounds to it.
  for (const double nothing : {0.5, 0.5 + 1e-9, 0.5001})
    expect_refused(detection_grid(grid, {.hit_probability = nothing}), "hit");
}

/// Without a blur, and with one too narrow to reach a neighbour.
TEST(MapFields, ABlurOfNearlyNothingIsNone) {
  const OccupancyGrid grid = room_grid();
  const PointSet points = points_in_room(1);
  const DetectionViewOptions none{.blur_sigma_m = 0.0, .max_detections = 20.0};
  for (const double sigma : {kTiny, 1e-160, 1e-20, 1e-5, 1e-3}) {
    SCOPED_TRACE(sigma);
    const auto p = likelihood_field(grid, {.blur_sigma_m = sigma});
    ASSERT_TRUE(p);
    EXPECT_EQ(observed(*p), observed(*likelihood_field(grid, {.blur_sigma_m = 0.0})));
    DetectionViewOptions narrow = none;
    narrow.blur_sigma_m = sigma;
    const auto d = detection_grid(grid, narrow);
    ASSERT_TRUE(d);
    EXPECT_EQ(observed(*d), observed(*detection_grid(grid, none)));
    DetectionFieldMaker maker;
    LikelihoodField a, b;
    ASSERT_TRUE(maker.make(grid, points, pose_in_room(1), {}, narrow, a));
    ASSERT_TRUE(maker.make(grid, points, pose_in_room(1), {}, none, b));
    EXPECT_EQ(observed(a), observed(b));
  }
}

/// `call(options changed by one)` for makers of views for a scan.
TEST(MapFields, OptionsOfMakersOfViews) {
  const OccupancyGrid grid = room_grid();
  const PointSet points = points_in_room(1);
  OccupancyFieldMaker occupancy;
  DetectionFieldMaker detections;
  const auto refused = [&](const FieldReach& reach, const OccupancyFieldOptions& o) {
    LikelihoodField view = make<LikelihoodField>(1);
    const bool error = !occupancy.make(grid, points, SE2d(), reach, o, view);
    EXPECT_EQ(view.empty(), error);
    return error;
  };
  const auto detections_refused = [&](const FieldReach& reach, DetectionViewOptions o) {
    LikelihoodField view = make<LikelihoodField>(1);
    const bool error = !detections.make(grid, points, SE2d(), reach, o, view);
    EXPECT_EQ(view.empty(), error);
    return error;
  };
  EXPECT_FALSE(refused({}, {}));
  EXPECT_FALSE(detections_refused({}, {.max_detections = 5}));
  for (const double bad : {kNan, kInf, -kInf, -0.1, 1e9}) {
    SCOPED_TRACE(bad);
    EXPECT_TRUE(refused({bad, 0.1}, {}));
    EXPECT_TRUE(refused({}, {.sigma_m = bad}));
    EXPECT_TRUE(refused({}, {.floor_probability = bad}));
    EXPECT_TRUE(refused({}, {.min_probability = bad}));
    const DetectionViewOptions good{.max_detections = 5};
    EXPECT_TRUE(detections_refused({bad, 0.1}, good));
    EXPECT_TRUE(detections_refused({0.1, bad}, good));
    EXPECT_TRUE(detections_refused({}, {.hit_probability = bad, .max_detections = 5}));
    EXPECT_TRUE(detections_refused({}, {.blur_sigma_m = bad, .max_detections = 5}));
    if (bad == 1e9) continue;
    EXPECT_TRUE(detections_refused({}, {.background = bad, .max_detections = 5}));
    EXPECT_TRUE(detections_refused({}, {.max_detections = bad}));
  }
  EXPECT_TRUE(detections_refused({}, {.hit_probability = 0.5001, .max_detections = 5}));
  EXPECT_TRUE(refused({0.1, kNan}, {}));
  EXPECT_TRUE(refused({0.1, -1.0}, {}));
}

/// A heading that is not known at all: the points may be anywhere on their circles.
TEST(MapFields, AHeadingReachOfMoreThanATurnIsAll) {
  const OccupancyGrid grid = room_grid();
  for (const PointSet& points :
       {points_in_room(1), points_at({{0.01F, 0.0F}}), points_at({{0, 0}})}) {
    OccupancyFieldMaker maker;
    LikelihoodField turn, more;
    ASSERT_TRUE(maker.make(grid, points, SE2d(), {0.3, 6.3}, {}, turn));
    for (const double reach : {100.0, 1e9, kHuge, kInf}) {
      ASSERT_TRUE(maker.make(grid, points, SE2d(), {0.3, reach}, {}, more)) << reach;
      EXPECT_EQ(observed(more), observed(turn)) << reach;
    }
  }
}

/// Cells of a nanometre: a metre is beyond the last one.
TEST(MapFields, ViewsOfCellsThatHaveNoNumber) {
  OccupancyGrid grid({.resolution_m = 1e-9});
  ScanRaster raster;
  EXPECT_FALSE(insert_points(grid, SE2d(), points_at({{1, 0}}), {}, raster));
  EXPECT_TRUE(insert_points(grid, SE2d(), points_at({{0, 0}}), {}, raster));
  LikelihoodField view;
  OccupancyFieldMaker occupancy;
  DetectionFieldMaker detections;
  const SE2d far(1.0, 1.0, Angle());
  EXPECT_FALSE(occupancy.make(grid, points_at({{0, 0}}), far, {0, 0}, {.sigma_m = 1e-9}, view));
  EXPECT_FALSE(detections.make(grid, points_at({{0, 0}}), far, {0, 0},
                               {.blur_sigma_m = 0.0, .max_detections = 5}, view));
}

TEST(MapFields, TablesRefuseSizes) {
  LikelihoodField field;
  const CellBox all{{-kMaxCell, -kMaxCell}, {kMaxCell, kMaxCell}};
  expect_refused(field.reset(0.05, all, 0.1), "all");
  expect_refused(field.reset(0.05, {{0, 0}, {-1, 5}}, 0.1), "no column");
  expect_refused(field.reset(0.05, {{0, 0}, {kMaxCell, 0}}, 0.1), "long");
  EXPECT_TRUE(field.empty());
  EXPECT_EQ(field.value({kMaxCell, -kMaxCell}), 0);
  for (const double bad : {kNan, kInf, 0.0, -1.0})
    expect_refused(field.reset(bad, {{0, 0}, {1, 1}}, 0.1), "resolution");
  ASSERT_TRUE(field.reset(0.05, {{kMaxCell - 1, 0}, {kMaxCell, 1}}, 0.1));
  EXPECT_EQ(field.value({-kMaxCell, -kMaxCell}), 0);
  PrecomputationGrids grids{LikelihoodField()};
  EXPECT_TRUE(grids.grid().empty());
  grids.build(make<LikelihoodField>(1));
  grids.build(LikelihoodField());
  EXPECT_TRUE(grids.grid().empty());
}

/// A scan without a return leaves no trace, also as the first one.
TEST(MapFields, AFirstScanWithoutReturnsLeavesAMapEmpty) {
  MultiResolutionGrid map;
  LaserScan scan = scan_in_room(0);
  scan.ranges_m.assign(90, kInfF);
  for (const LaserScan& nothing : {scan, LaserScan()}) {
    ASSERT_TRUE(map.insert(SE2d(), nothing));
    EXPECT_TRUE(map.empty());
  }
  ASSERT_TRUE(map.insert(SE2d(), PointSet()));
  EXPECT_TRUE(map.empty());
  EXPECT_TRUE(map.tables().empty());
  ASSERT_TRUE(map.insert(SE2d(), scan_in_room(0)));
  EXPECT_FALSE(map.empty());
  ASSERT_TRUE(map.insert(SE2d(), scan));
  EXPECT_FALSE(map.empty());
}

// --- Distances and rays ----------------------------------------------------------------------

TEST(MapFields, MasksOfDistances) {
  const std::vector<std::uint8_t> two{0, 1};
  expect_refused(DistanceField::of_mask(two, 3, 1, 0.1), "sizes");
  expect_refused(DistanceField::of_mask({}, 0, 0, 0.1), "nothing");
  expect_refused(DistanceField::of_mask(two, -1, -2, 0.1), "negative");
  expect_refused(DistanceField::of_mask(two, 1 << 30, 1 << 30, 0.1), "1e18 cells");
  expect_refused(DistanceField::of_mask(two, 30000, 1, 0.1), "long");
  for (const double bad : {kNan, kInf, 0.0, -1.0})
    expect_refused(DistanceField::of_mask(two, 2, 1, bad), "resolution");
  constexpr int kLast = std::numeric_limits<int>::max();
  for (const Cell& origin : {Cell{kLast, 0}, Cell{0, -kLast - 1}, Cell{kMaxCell + 1, 0}})
    expect_refused(DistanceField::of_mask(two, 2, 1, 0.1, origin), "origin");
  const auto far = DistanceField::of_mask(two, 2, 1, 0.1, {kMaxCell, -kMaxCell});
  ASSERT_TRUE(far);
  EXPECT_EQ(far->squared_cells({kMaxCell, -kMaxCell}), 1);
  EXPECT_EQ(far->squared_cells({-kMaxCell, kMaxCell}), DistanceField::kFar);
  EXPECT_TRUE(std::isinf(far->distance_m({-kMaxCell, kMaxCell})));
}

/// The longest field: the distance along it is known, and a likelihood that hardly falls over it
/// has no table as long as its square, 8e8.
TEST(MapFields, TheWidestLikelihoodOfTheLongestField) {
  std::vector<std::uint8_t> mask(DistanceField::kMaxSide, 0);
  mask[0] = 1;
  const auto field = DistanceField::of_mask(mask, DistanceField::kMaxSide, 1, 1.0);
  ASSERT_TRUE(field);
  EXPECT_EQ(field->row(0).back(), 28999 * 28999);
  for (const double sigma : {1.0, 1000.0}) {
    const DistanceLikelihood wide{sigma, kTiny};
    const auto likelihood = likelihood_field(*field, wide);
    ASSERT_TRUE(likelihood);
    for (const int x : {0, 1, 50, 170, 171, 1000, 20000, 28999}) {
      const double exact = std::log(kTiny + std::exp(-0.5 * x * x / (sigma * sigma)));
      EXPECT_NEAR(likelihood->log_likelihood({x, 0}), exact, 0.51 * likelihood->log_step()) << x;
    }
  }
  const auto nothing = DistanceField::of_mask(std::vector<std::uint8_t>(20, 0), 20, 1, 1.0);
  const auto floor = likelihood_field(*nothing, {1000.0, kTiny});
  ASSERT_TRUE(floor);
  EXPECT_EQ(floor->value({3, 0}), 0) << "without an obstacle";
  for (const double bad : {kNan, kInf, 0.0, -1.0, 1e9})
    expect_refused(likelihood_field(*field, {bad, 0.1}), "sigma");
  for (const double bad : {kNan, kInf, 0.0, -1.0, 1.0})
    expect_refused(likelihood_field(*field, {0.1, bad}), "floor");
}

TEST(MapFields, RaysOfOddPosesDirectionsAndLimits) {
  const auto caster = make<RayCaster>(2);
  const std::vector<float> cosines{1.0F, 0.0F, 0.6F}, sines{0.0F, -1.0F, 0.8F};
  std::vector<float> ranges(3);
  const auto cast = [&](const SE2d& pose, double limit) {
    ranges.assign(3, -7.0F);
    caster.cast(pose, cosines, sines, limit, ranges);
    return Observed(ranges.begin(), ranges.end());
  };
  for (const SE2d& pose : bad_poses()) EXPECT_EQ(cast(pose, 5.0), Observed(3, 5.0));
  EXPECT_EQ(cast(SE2d(1e9, -1e9, Angle()), 5.0), Observed(3, 5.0));
  for (const double none : {0.0, -1.0, -kInf, kNan})
    EXPECT_EQ(cast(SE2d(), none), Observed(3, 0.0));
  const Observed far = cast(SE2d(), 1e9);
  EXPECT_EQ(far, cast(SE2d(), kInf));
  for (const double range : far) EXPECT_LE(range, 0.1 * RayCaster::kMaxCells * 1.0001);
  for (const float bad : {kNanF, kInfF, -kInfF, 3e38F}) {
    const std::vector<float> no_cosines(3, bad);
    caster.cast(SE2d(), no_cosines, sines, 5.0, ranges);
    for (const float range : ranges) EXPECT_TRUE(range >= 0 && range <= 5.0F) << range;
  }
  caster.cast(SE2d(), {}, {}, 5.0, {});
  // A field at the last cells, where NaN would saturate to a cell of it.
  const std::vector<std::uint8_t> mask{0, 0, 0, 1};
  const auto last = DistanceField::of_mask(mask, 2, 2, 0.1, {-kMaxCell, -kMaxCell});
  ASSERT_TRUE(last);
  RayCaster(*last).cast(SE2d(kNan, kNan, Angle()), cosines, sines, 5.0, ranges);
  EXPECT_EQ(ranges, std::vector<float>(3, 5.0F));
}

/// A ray as long as cells are numbered, over cells of 1000 km.
TEST(MapFields, SegmentsBetweenPointsThatSaturate) {
  for (const double far : {1e9, 1e12}) {
    std::int64_t cells = 0;
    Cell last;
    for_each_cell_on_segment(Eigen::Vector2d(-far, 0.0), Eigen::Vector2d(far, 0.0), far / 1000,
                             [&](const Cell& c) {
                               ++cells;
                               last = c;
                             });
    EXPECT_NEAR(static_cast<double>(cells), 2001, 1);
    EXPECT_EQ(last.y, 0);
  }
  int visits = 0;
  for_each_cell_on_segment(Eigen::Vector2d(kNan, kNan), Eigen::Vector2d(-kInf, -kHuge), 0.05,
                           [&](const Cell& c) {
                             ++visits;
                             EXPECT_EQ(c, (Cell{-kMaxCell, -kMaxCell}));
                           });
  EXPECT_EQ(visits, 1);
}

/// Beams in one place, of one direction, or with steps that make no circle.
TEST(MapFields, ScansOfStrangeShapes) {
  ScanRaster raster;
  for (const double step : {0.0, 1e-300, 1e-12, 3.2, 1e9, -1e9, 1e300})
    for (const double first : {0.0, 1e9, -1e300})
      for (const std::size_t n : {0U, 1U, 2U, 1000U}) {
        SCOPED_TRACE(step);
        LaserScan scan;
        scan.first_bearing = Angle::radians(first);
        scan.bearing_step = Angle::radians(step);
        scan.max_range_m = 10.0F;
        scan.ranges_m.assign(n, 2.0F);
        OccupancyGrid once, every, filled;
        const auto insert = [&]<class FreeSpace>(OccupancyGrid& grid, FreeSpace) {
          return insert_scan<FreeSpace>(grid, SE2d(), scan, {}, raster).has_value();
        };
        // Bearings may overflow: then there is no place, and nothing has changed.
        const bool placed = std::isfinite(first + step * static_cast<double>(n));
        ASSERT_EQ(insert(once, OncePerScan()), placed || n == 0);
        ASSERT_EQ(insert(every, EveryBeam()), placed || n == 0);
        ASSERT_EQ(insert(filled, FillBetweenBeams()), placed || n == 0);
        for (const OccupancyGrid* grid : {&once, &every, &filled})
          EXPECT_EQ(grid->bounds().has_value(), placed && n > 0);
      }
  // The same end and the sensor's own place a thousand times.
  for (const Eigen::Vector2f& p : {Eigen::Vector2f(1, 1), Eigen::Vector2f(0, 0)}) {
    OccupancyGrid grid;
    const PointSet equal = points_at(std::vector<Eigen::Vector2f>(70000, p));
    ASSERT_TRUE(insert_points<EveryBeam>(grid, SE2d(), equal, {}, raster));
    ASSERT_TRUE(insert_points<FillBetweenBeams>(grid, SE2d(), equal, {}, raster));
    EXPECT_NEAR(grid.probability(cell_of(p.cast<double>(), 0.05)), 0.98, 0.001);
  }
}

}  // namespace
}  // namespace wayfare::tests
