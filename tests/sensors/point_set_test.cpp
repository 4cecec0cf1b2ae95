#include <wayfare/sensors/point_set.hpp>

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include <wayfare/core/random.hpp>
#include <wayfare/eval/consistency.hpp>

namespace wayfare {
namespace {

// Kernels read whole vectors: the padding must be there and must not reach farther than the points.
TEST(PointSet, IsPaddedToWholeVectorsWithItsLastPoint) {
  PointSet points;
  EXPECT_TRUE(points.padded_x_m().empty());
  for (int n = 1; n <= 40; ++n) {
    const Eigen::Vector2f p(static_cast<float>(n), static_cast<float>(-n));
    points.push_back(p);
    ASSERT_EQ(points.size(), static_cast<std::size_t>(n));
    ASSERT_EQ(points.padded_x_m().size() % PointSet::kLanes, 0U);
    ASSERT_EQ(points.padded_x_m().size(), points.padded_y_m().size());
    for (std::size_t i = points.size(); i < points.padded_x_m().size(); ++i) {
      EXPECT_EQ(points.padded_x_m()[i], p.x());
      EXPECT_EQ(points.padded_y_m()[i], p.y());
    }
    EXPECT_EQ(points[points.size() - 1], p);
    EXPECT_EQ(points[0], Eigen::Vector2f(1.0F, -1.0F));
  }
  EXPECT_FLOAT_EQ(points.max_norm_m(), 40.0F * std::sqrt(2.0F));
}

//! [end points]
TEST(PointSet, EndPointsOnlyOfBeamsThatReturned) {
  LaserScan scan;
  scan.first_bearing = Angle::degrees(-90.0);
  scan.bearing_step = Angle::degrees(45.0);
  scan.min_range_m = 0.5F;
  scan.max_range_m = 10.0F;
  scan.ranges_m = {2.0F, std::numeric_limits<float>::quiet_NaN(), 0.4F, 10.0F, 3.0F};
  // The laser points along the base's y axis from (1, 0): its −90° is the base's 0°, its 90° 180°.
  const PointSet points = end_points(scan, SE2d(1.0, 0.0, Angle::degrees(90.0)));
  ASSERT_EQ(points.size(), 2U);
  EXPECT_LT((points[0] - Eigen::Vector2f(3.0F, 0.0F)).norm(), 1e-6F);
  EXPECT_LT((points[1] - Eigen::Vector2f(-2.0F, 0.0F)).norm(), 1e-6F);
}
//! [end points]

TEST(PointSet, ThinnedPointsAreSpacedAndNear) {
  PointSet wall;
  for (int k = 0; k <= 1000; ++k) wall.push_back({0.01F * static_cast<float>(k), 0.0F});
  wall.push_back({std::numeric_limits<float>::quiet_NaN(), 0.0F});
  const PointSet kept = thin(wall, 0.095F, 5.05F);
  EXPECT_EQ(kept.size(), 51U);  // every tenth from 0 m to 5 m
  for (std::size_t i = 1; i < kept.size(); ++i) EXPECT_GE((kept[i] - kept[i - 1]).norm(), 0.095F);
  EXPECT_LE(kept.max_norm_m(), 5.05F);
  EXPECT_EQ(thin(wall, 0.0F, 100.0F).size(), 1001U);
}

TEST(PointSet, ThinningKeepsTheLastPointBeforeAJumpApartFromTheNextWall) {
  PointSet walls;
  for (int k = 0; k < 5; ++k) walls.push_back({0.01F * static_cast<float>(k), 0.0F});
  for (int k = 0; k < 5; ++k) walls.push_back({0.01F * static_cast<float>(k), 1.0F});
  const PointSet kept = thin(walls, 0.1F, 10.0F);
  ASSERT_EQ(kept.size(), 2U);
  EXPECT_EQ(kept[1], Eigen::Vector2f(0.0F, 1.0F));
}

// A line through the points of a noisy scan of a straight wall is unbiased: its slope has no mean.
// Points chosen by their own distance from the last one kept turn it by 0.16° in the scan's sense.
TEST(PointSet, ThinningDoesNotTurnAWall) {
  constexpr int kScans = 400, kSteps = 720;
  constexpr double kWall_m = 1.5, kNoise_m = 0.02;
  for (const double sense : {1.0, -1.0}) {
    Rng rng(7);
    eval::IndependentMean slope;
    for (int s = 0; s < kScans; ++s) {
      PointSet wall;
      for (int k = 0; k < kSteps; ++k) {
        const double bearing = sense * (-1.2 + 2.4 * k / kSteps);
        const double range = kWall_m / std::cos(bearing) + kNoise_m * rng.normal();
        const Eigen::Vector2d p(range * std::cos(bearing), range * std::sin(bearing));
        wall.push_back(p.cast<float>());
      }
      const PointSet kept = thin(wall, 0.1F, 10.0F);
      double across = 0.0, along = 0.0;
      for (std::size_t i = 0; i < kept.size(); ++i) {
        const Eigen::Vector2d p = kept[i].cast<double>();
        across += (p.x() - kWall_m) * p.y();
        along += p.y() * p.y();
      }
      slope.add(across / along);
    }
    EXPECT_LT(slope.standard_error(), 5e-5);
    EXPECT_LT(std::abs(slope.mean()), 4.0 * slope.standard_error()) << sense;
  }
}

}  // namespace
}  // namespace wayfare
