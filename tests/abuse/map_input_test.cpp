// What maps, makers and fields do with input and options at the border of what they take.

#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include <wayfare/map/voxel_filter.hpp>

#include "abuse/abuse.hpp"
#include "abuse/map_cases.hpp"

namespace wayfare::tests {
namespace {

const float kNanF = static_cast<float>(kNan), kInfF = static_cast<float>(kInf);

/// A Result's Error says something.
template <class R>
void expect_refused(const R& result, const std::string& what) {
  ASSERT_FALSE(result) << what;
  EXPECT_GT(result.error().to_string().size(), 15U) << what;
}

/// Points that no map of points takes.
std::vector<PointSet> bad_points() {
  return {PointSet(), points_at({{kNanF, 0}}), points_at({{0, 1}, {0, kInfF}}),
          points_at({{-kInfF, 0}}), points_at({{1e30F, 0}}), points_at({{0, 0}, {1e9F, -1e9F}})};
}
std::vector<SE2d> bad_poses() {
  return {{kNan, 0, Angle()},   {0, kInf, Angle()},  {0, 0, Angle::radians(kNan)},
          {0, 0, Angle::radians(kInf)}, {1e300, -1e300, Angle()}};
}

template <class Make>
void expect_point_map_refuses(const Make& make_map) {
  const PointSet good = points_in_room(0);
  for (const PointSet& bad : bad_points()) {
    const PlacedPoints placed{&bad, SE2d()};
    expect_refused(make_map(std::span(&placed, 1)), std::to_string(bad.size()) + " bad points");
    // Good points beside do not help, unless there are none to be refused.
    const PlacedPoints two[] = {{&good, SE2d()}, {&bad, SE2d()}};
    EXPECT_EQ(make_map(std::span(two)).has_value(), bad.empty());
  }
  for (const SE2d& pose : bad_poses()) {
    const PlacedPoints placed{&good, pose};
    expect_refused(make_map(std::span(&placed, 1)), "a bad pose");
  }
  expect_refused(make_map(std::span<const PlacedPoints>()), "nothing");
  const PlacedPoints null;
  expect_refused(make_map(std::span(&null, 1)), "null");
}

TEST(MapInput, MapsOfPointsRefuseWhatHasNoPlace) {
  expect_point_map_refuses([](auto scans) { return likelihood_field(scans); });
  expect_point_map_refuses([](auto scans) { return SurfaceMap::make(scans); });
  expect_point_map_refuses([](auto scans) { return NdtMap::make(scans); });
}

TEST(MapInput, MapsOfOnePointAndOfEqualPoints) {
  for (const std::size_t n : {1U, 2U, 5U, 1000U}) {
    SCOPED_TRACE(n);
    const PointSet points = points_at(std::vector<Eigen::Vector2f>(n, {1.0F, 2.0F}));
    const PlacedPoints placed{&points, SE2d()};
    const auto field = likelihood_field({&placed, 1});
    const auto surface = SurfaceMap::make({&placed, 1});
    const auto ndt = NdtMap::make({&placed, 1}, {.min_points = 1});
    ASSERT_TRUE(field && surface && ndt);
    EXPECT_GT(field->value(cell_of({1, 2}, field->resolution_m())), 3500);
    ASSERT_EQ(surface->points().size(), 1U);
    EXPECT_TRUE(surface->points()[0].normal.isZero(0)) << "a point has no direction";
    const NdtCell* cell = ndt->levels()[0].at({1, 2}, 0);
    ASSERT_NE(cell, nullptr);
    EXPECT_TRUE(cell->mean.allFinite() && cell->information.allFinite());
    EXPECT_NEAR(cell->mean.x(), 1.0, 1e-9);
  }
}

/// Two scans of one point each, as far from one another as a limit allows, and farther: no map
/// allocates for the empty space between what it has no room for.
TEST(MapInput, PointsFarApartAreRefusedBeforeTheyAreStored) {
  for (const float far : {100.0F, 1100.0F, 1e4F, 1e5F, 1e6F, 9e6F, 1e9F, 1e20F, 3e38F}) {
    SCOPED_TRACE(far);
    const PointSet points = points_at({{-far, -far}, {far, far}});
    const PlacedPoints placed{&points, SE2d()};
    EXPECT_EQ(likelihood_field({&placed, 1}).has_value(), far <= 100);
    // 2²⁶ squares of 25 cm are 2 km a side; 2²⁴ of 50 cm about the origin reach 1 km.
    const auto surface = SurfaceMap::make({&placed, 1});
    EXPECT_EQ(surface.has_value(), far < 1e3F);
    EXPECT_EQ(NdtMap::make({&placed, 1}, {.min_points = 1}).has_value(), far < 1e3F);
  }
  const PointSet points = points_at({{-700.0F, -700.0F}, {700.0F, 700.0F}});
  const PlacedPoints placed{&points, SE2d()};
  const auto ndt = NdtMap::make({&placed, 1}, {.cell_sizes_m = {0.5}, .min_points = 1});
  ASSERT_TRUE(ndt);  // 8 million squares a tiling
  EXPECT_NE(ndt->levels()[0].at({700, 700}, 3), nullptr);
  EXPECT_EQ(ndt->levels()[0].at({0, 0}, 3), nullptr);
}

TEST(MapInput, OptionsOfMapsOfPoints) {
  const PointSet points = points_in_room(0);
  const PlacedPoints placed{&points, SE2d()};
  const std::span<const PlacedPoints> scans(&placed, 1);
  std::vector<double> not_positive(kNotFinite.begin(), kNotFinite.end());
  not_positive.insert(not_positive.end(), {0.0, -1.0, -kHuge});
  for (const double bad : not_positive) {
    SCOPED_TRACE(bad);
    expect_refused(likelihood_field(scans, {.resolution_m = bad}), "resolution");
    expect_refused(likelihood_field(scans, {.sigma_m = bad}), "sigma");
    expect_refused(likelihood_field(scans, {.floor_probability = bad}), "floor");
    expect_refused(SurfaceMap::make(scans, {.spacing_m = bad}), "spacing");
    expect_refused(SurfaceMap::make(scans, {.normal_radius_m = bad}), "radius");
    if (bad < 0 || std::isnan(bad)) {
      expect_refused(SurfaceMap::make(scans, {.max_flatness = bad}), "flatness");
      expect_refused(NdtMap::make(scans, {.min_sigma_m = bad}), "sigma");
    }
    if (bad != kInf) expect_refused(NdtMap::make(scans, {.cell_sizes_m = {1.0, bad}}), "sizes");
    expect_refused(voxel_filter(points, bad), "side");
  }
  expect_refused(NdtMap::make(scans, {.cell_sizes_m = {}}), "no sizes");
  for (const int bad : {0, -1, std::numeric_limits<int>::min()})
    expect_refused(NdtMap::make(scans, {.min_points = bad}), "min_points");
  for (const double tiny : {kTiny, 1e-200, 1e-9}) {
    expect_refused(NdtMap::make(scans, {.cell_sizes_m = {tiny}}), "cells too small");
    expect_refused(NdtMap::make(scans, {.min_sigma_m = tiny}), "its inverse square overflows");
    expect_refused(SurfaceMap::make(scans, {.spacing_m = tiny}), "spacing");
    expect_refused(voxel_filter(points, tiny), "side");
    expect_refused(likelihood_field(scans, {.resolution_m = tiny}), "resolution");
    const auto narrow = likelihood_field(scans, {.sigma_m = tiny});
    EXPECT_TRUE(narrow) << "a kernel without width, no NaN";
  }
  expect_refused(likelihood_field(scans, {.floor_probability = 1.0}), "floor");
  EXPECT_TRUE(likelihood_field(scans, {.sigma_m = 1e-3, .floor_probability = kTiny}));
  EXPECT_TRUE(likelihood_field(scans, {.floor_probability = std::nextafter(1.0, 0.0)}));
}

TEST(MapInput, NearestPointsOfOddQuestions) {
  const auto map = make<SurfaceMap>(2);
  const Eigen::Vector2f there = map.points()[7].point;
  EXPECT_EQ(map.nearest(there, 0.0F), &map.points()[7]);
  EXPECT_EQ(map.nearest(there, kInfF), &map.points()[7]);
  EXPECT_EQ(map.nearest(there, 3e38F), &map.points()[7]);
  for (const float radius : {-0.01F, -1.0F, -kInfF, kNanF}) {
    EXPECT_EQ(map.nearest(there, radius), nullptr) << radius;
    map.for_each_within(there, radius, [&](const SurfacePoint&) { ADD_FAILURE() << radius; });
  }
  for (const float far : {1e9F, -1e30F, 3e38F, kInfF, -kInfF, kNanF}) {
    EXPECT_EQ(map.nearest({far, 0.0F}, 1.0F), nullptr) << far;
    EXPECT_EQ(map.nearest({0.0F, far}, 1.0F), nullptr) << far;
  }
  EXPECT_EQ(SurfaceMap().nearest({0, 0}, kInfF), nullptr);
  const auto ndt = make<NdtMap>(2);
  for (const double far : {1e9, -kHuge, kInf, kNan})
    for (int t = 0; t < 4; ++t) EXPECT_EQ(ndt.levels()[0].at({far, -far}, t), nullptr);
}

TEST(MapInput, VoxelsOfNothingOneAndEqualPoints) {
  EXPECT_EQ(voxel_filter(PointSet(), 0.1)->size(), 0U);
  EXPECT_EQ(voxel_filter(points_at({{1, 1}}), 1e300)->size(), 1U);
  const auto equal = voxel_filter(points_at(std::vector<Eigen::Vector2f>(999, {0.3F, -7.0F})), 0.1);
  ASSERT_EQ(equal->size(), 1U);
  EXPECT_EQ((*equal)[0], Eigen::Vector2f(0.3F, -7.0F));
  for (const PointSet& bad : bad_points())
    if (!bad.empty()) expect_refused(voxel_filter(bad, 0.1), "points");
}

// --- Grids -----------------------------------------------------------------------------------

/// Fields of a grid of the room, one of nothing, and one with cells 1e9 apart.
struct Grids {
  OccupancyGrid room = room_grid(), empty, sparse;
  Grids() {
    sparse.update({-kMaxCell + 1, -kMaxCell + 1}, LogOdds::from_nats(2.0));
    sparse.update({kMaxCell - 1, kMaxCell - 1}, LogOdds::from_nats(2.0));
  }
};

TEST(MapInput, GridsThatAreEmptyOrTooLargeHaveNoTables) {
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

TEST(MapInput, OptionsOfFieldsOfGrids) {
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
    if (!(bad >= 0 && bad < 2))
      expect_refused(detection_grid(grid, {.blur_sigma_m = bad}), "blur");
  }
  for (const int margin : {-1, std::numeric_limits<int>::min(), kMaxCell,
                           std::numeric_limits<int>::max()}) {
    ProbabilityGrid table;
    expect_refused(table.make(grid, 0.5, margin), "margin");
  }
  // One half says nothing about the cell, and neither does what rounds to it.
  for (const double nothing : {0.5, 0.5 + 1e-9, 0.5001})
    expect_refused(detection_grid(grid, {.hit_probability = nothing}), "hit");
}

/// Without a blur, and with one too narrow to reach a neighbour.
TEST(MapInput, ABlurOfNearlyNothingIsNone) {
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
TEST(MapInput, OptionsOfMakersOfViews) {
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
TEST(MapInput, AHeadingReachOfMoreThanATurnIsAll) {
  const OccupancyGrid grid = room_grid();
  for (const PointSet& points : {points_in_room(1), points_at({{0.01F, 0.0F}}), points_at({{0, 0}})}) {
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
TEST(MapInput, ViewsOfCellsThatHaveNoNumber) {
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

TEST(MapInput, TablesRefuseSizes) {
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
TEST(MapInput, AFirstScanWithoutReturnsLeavesAMapEmpty) {
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

TEST(MapInput, MasksOfDistances) {
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
TEST(MapInput, TheWidestLikelihoodOfTheLongestField) {
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

TEST(MapInput, RaysOfOddPosesDirectionsAndLimits) {
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
  for (const double none : {0.0, -1.0, -kInf, kNan}) EXPECT_EQ(cast(SE2d(), none), Observed(3, 0.0));
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
TEST(MapInput, SegmentsBetweenPointsThatSaturate) {
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
TEST(MapInput, ScansOfStrangeShapes) {
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
