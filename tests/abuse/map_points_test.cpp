// What maps of points do with input and options at the border of what they take.

#include <cmath>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include <wayfare/map/ndt_map.hpp>
#include <wayfare/map/surface_map.hpp>
#include <wayfare/map/voxel_filter.hpp>

#include "abuse/abuse.hpp"
#include "abuse/map_cases.hpp"

namespace wayfare::tests {
namespace {

/// Points that no map of points takes.
std::vector<PointSet> bad_points() {
  return {PointSet(),
          points_at({{kNanF, 0}}),
          points_at({{0, 1}, {0, kInfF}}),
          points_at({{-kInfF, 0}}),
          points_at({{1e30F, 0}}),
          points_at({{0, 0}, {1e9F, -1e9F}})};
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

TEST(MapsOfPoints, MapsOfPointsRefuseWhatHasNoPlace) {
  expect_point_map_refuses([](auto scans) { return likelihood_field(scans); });
  expect_point_map_refuses([](auto scans) { return SurfaceMap::make(scans); });
  expect_point_map_refuses([](auto scans) { return NdtMap::make(scans); });
}

TEST(MapsOfPoints, MapsOfOnePointAndOfEqualPoints) {
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
TEST(MapsOfPoints, PointsFarApartAreRefusedBeforeTheyAreStored) {
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

TEST(MapsOfPoints, OptionsOfMapsOfPoints) {
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

TEST(MapsOfPoints, NearestPointsOfOddQuestions) {
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

TEST(MapsOfPoints, VoxelsOfNothingOneAndEqualPoints) {
  EXPECT_EQ(voxel_filter(PointSet(), 0.1)->size(), 0U);
  EXPECT_EQ(voxel_filter(points_at({{1, 1}}), 1e300)->size(), 1U);
  const auto equal = voxel_filter(points_at(std::vector<Eigen::Vector2f>(999, {0.3F, -7.0F})), 0.1);
  ASSERT_EQ(equal->size(), 1U);
  EXPECT_EQ((*equal)[0], Eigen::Vector2f(0.3F, -7.0F));
  for (const PointSet& bad : bad_points())
    if (!bad.empty()) expect_refused(voxel_filter(bad, 0.1), "points");
}

}  // namespace
}  // namespace wayfare::tests
