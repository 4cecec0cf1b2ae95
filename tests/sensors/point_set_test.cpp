#include <wayfare/sensors/point_set.hpp>

#include <limits>

#include <gtest/gtest.h>

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

}  // namespace
}  // namespace wayfare
