// Copies, moves and threads of every map, and of the makers with their cached kernels.

#include <optional>
#include <utility>

#include <gtest/gtest.h>

#include "abuse/abuse.hpp"
#include "abuse/map_cases.hpp"

namespace wayfare::tests {
namespace {

template <class Map>
class EveryMapsLife : public ::testing::Test {};
using EveryMap =
    ::testing::Types<OccupancyGrid, MultiResolutionGrid, ProbabilityGrid, LikelihoodField,
                     PrecomputationGrids, DistanceField, RayCaster, SurfaceMap, NdtMap>;
TYPED_TEST_SUITE(EveryMapsLife, EveryMap, );

TYPED_TEST(EveryMapsLife, HasValueSemantics) {
  expect_value_semantics(make<TypeParam>(2), [](const TypeParam& map) { return observed(map); });
  expect_value_semantics(make<TypeParam>(3), [](TypeParam& map) {
    const Observed before = observed(map);
    map = make<TypeParam>(1);
    Observed after = observed(map);
    after.insert(after.end(), before.begin(), before.end());
    return after;
  });
}

TYPED_TEST(EveryMapsLife, IsOneOfTwoInTwoThreads) {
  const auto both = in_two_threads([](int) { return observed(make<TypeParam>(2)); });
  EXPECT_EQ(both[0], both[1]);
}

TYPED_TEST(EveryMapsLife, ReadersShareAMap) {
  const auto map = make<TypeParam>(2);
  const auto both = in_two_threads([&](int) { return observed(map); });
  EXPECT_EQ(both[0], both[1]);
}

/// Copies share tiles: each thread writes to its own.
TEST(MapLife, CopiesAreWrittenInTwoThreads) {
  const auto grid = make<OccupancyGrid>(2);
  const auto multi = make<MultiResolutionGrid>(2);
  const Observed before = observed(grid);
  const auto both = in_two_threads([&](int) {
    OccupancyGrid mine = grid;
    MultiResolutionGrid levels = multi;
    ScanRaster raster;
    for (int k = 3; k < 6; ++k) {
      (void)insert_scan<FillBetweenBeams>(mine, pose_in_room(k), scan_in_room(k), {}, raster);
      (void)levels.insert(pose_in_room(k), scan_in_room(k));
    }
    Observed out = observed(mine);
    observe(levels, out);
    return out;
  });
  EXPECT_EQ(both[0], both[1]);
  EXPECT_EQ(observed(grid), before);
}

/// A default caster, or one moved from, has no cells: every ray ends at the limit.
TEST(MapLife, ACasterWithoutCellsSeesNothing) {
  RayCaster caster = make<RayCaster>(2);
  const Observed nothing = observed(RayCaster());
  EXPECT_NE(observed(caster), nothing);
  const RayCaster taken = std::move(caster);
  EXPECT_EQ(observed(caster), nothing);  // NOLINT(bugprone-use-after-move)
  EXPECT_EQ(nothing, Observed(100, 20.0));
}

/// What is left of a map that was moved from is empty, and can be asked.
TEST(MapLife, MovedFromMapsAreEmpty) {
  auto field = make<DistanceField>(2);
  const DistanceField field_taken = std::move(field);
  EXPECT_TRUE(field.empty());  // NOLINT(bugprone-use-after-move)
  EXPECT_EQ(field.squared_cells({0, 0}), DistanceField::kFar);
  EXPECT_FALSE(likelihood_field(field));
  EXPECT_EQ(observed(RayCaster(field)), observed(RayCaster()));
  auto surface = make<SurfaceMap>(2);
  const SurfaceMap surface_taken = std::move(surface);
  EXPECT_TRUE(surface.empty());  // NOLINT(bugprone-use-after-move)
  auto grids = make<PrecomputationGrids>(2);
  const PrecomputationGrids grids_taken = std::move(grids);
  EXPECT_TRUE(grids.grid().empty());  // NOLINT(bugprone-use-after-move)
  auto ndt = make<NdtMap>(2);
  const NdtMap ndt_taken = std::move(ndt);
  EXPECT_TRUE(ndt.empty());  // NOLINT(bugprone-use-after-move)
}

/// `make(maker)` is what the maker gives for one and the same question.
template <class Maker, class Make>
void expect_makers_life(const Make& make_with) {
  Maker used;
  const Observed expected = make_with(used);
  ASSERT_GT(expected.size(), 100U);
  expect_value_semantics(used, make_with);
  const Maker taken = std::move(used);
  EXPECT_EQ(make_with(used), expected) << "a maker moved from prepares its kernels again";
  const auto both = in_two_threads([&](int) {
    Maker own = taken;
    return make_with(own);
  });
  EXPECT_EQ(both[0], expected);
  EXPECT_EQ(both[1], expected);
}

TEST(MapLife, MakersOutliveTheirMoves) {
  const OccupancyGrid grid = room_grid();
  const PointSet points = points_in_room(1);
  const SE2d pose = pose_in_room(1);
  expect_makers_life<OccupancyFieldMaker>([&](OccupancyFieldMaker& maker) {
    LikelihoodField view;
    EXPECT_TRUE(maker.make(grid, points, pose, {}, {}, view));
    return observed(view);
  });
  expect_makers_life<DetectionFieldMaker>([&](DetectionFieldMaker& maker) {
    LikelihoodField view;
    EXPECT_TRUE(maker.make(grid, points, pose, {}, {.max_detections = 20.0}, view));
    return observed(view);
  });
  expect_makers_life<LikelihoodFieldMaker>([&](LikelihoodFieldMaker& maker) {
    LikelihoodField view;
    const PlacedPoints placed{&points, pose};
    EXPECT_TRUE(maker.make({&placed, 1}, {}, view));
    return observed(view);
  });
  expect_makers_life<ScanRaster>([&](ScanRaster& raster) {
    OccupancyGrid mine({.resolution_m = 0.1});
    for (int k = 0; k < 3; ++k)
      EXPECT_TRUE(insert_scan<EveryBeam>(mine, pose_in_room(k), scan_in_room(k), {}, raster));
    return observed(mine);
  });
}

}  // namespace
}  // namespace wayfare::tests
