#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <wayfare/slam/graph_slam.hpp>

#include "support.hpp"

namespace wayfare {
namespace {

using ::testing::HasSubstr;
constexpr auto kNoOdometry = std::nullopt;

TEST(GraphSlamBadInput, AnEmptyRecordingIsAnError) {
  const auto slam = run_graph_slam({});
  ASSERT_FALSE(slam);
  EXPECT_THAT(slam.error().message, HasSubstr("no scans"));
}

TEST(GraphSlamBadInput, RefusesABadScanAndContinues) {
  GraphSlam slam;
  ASSERT_TRUE(slam.add_scan(room_scan(1.0, 3.0, 2.0), kNoOdometry));

  LaserScan empty = room_scan(2.0, 3.0, 2.0);
  empty.ranges_m.clear();
  const auto no_beams = slam.add_scan(empty, kNoOdometry);
  ASSERT_FALSE(no_beams);
  EXPECT_THAT(no_beams.error().message, HasSubstr("no beams"));

  const auto earlier = slam.add_scan(room_scan(0.5, 3.0, 2.0), kNoOdometry);
  ASSERT_FALSE(earlier);
  EXPECT_THAT(earlier.error().message, HasSubstr("earlier"));

  LaserScan skewed = room_scan(2.0, 3.0, 2.0);
  skewed.bearing_step = Angle::radians(std::numeric_limits<double>::quiet_NaN());
  EXPECT_FALSE(slam.add_scan(skewed, kNoOdometry));

  const SE2d nowhere(std::numeric_limits<double>::infinity(), 0.0, Angle{});
  EXPECT_FALSE(
      slam.add_scan(room_scan(2.0, 3.0, 2.0), Transform2<frame::Odom, frame::Base>(nowhere)));

  EXPECT_EQ(slam.statistics().scans, 1U);
  ASSERT_TRUE(slam.add_scan(room_scan(2.0, 3.05, 2.0), kNoOdometry));
  EXPECT_EQ(slam.trajectory().size(), 2U);
}

TEST(GraphSlamBadInput, NanRangesAreNoReturns) {
  GraphSlam slam;
  ASSERT_TRUE(slam.add_scan(room_scan(0.0, 3.0, 2.0), kNoOdometry));
  LaserScan holes = room_scan(0.2, 3.1, 2.0);
  for (std::size_t i = 0; i < holes.ranges_m.size(); i += 3)
    holes.ranges_m[i] = std::numeric_limits<float>::quiet_NaN();
  const auto outcome = slam.add_scan(holes, kNoOdometry);
  ASSERT_TRUE(outcome);
  EXPECT_TRUE(outcome->matched);
  EXPECT_NEAR(outcome->T_map_base.raw().x(), 0.1, 0.02);
}

TEST(GraphSlamBadInput, AScanWithoutReturnsGetsTheOdometryPose) {
  GraphSlam slam;
  const auto at = [](double x) {
    return Transform2<frame::Odom, frame::Base>(SE2d(x, 0, Angle{}));
  };
  ASSERT_TRUE(slam.add_scan(room_scan(0.0, 3.0, 2.0), at(0.0)));
  LaserScan blind = room_scan(0.2, 3.4, 2.0);
  for (float& r : blind.ranges_m) r = 50.0F;  // beyond max_range_m
  const auto outcome = slam.add_scan(blind, at(0.4));
  ASSERT_TRUE(outcome);
  EXPECT_FALSE(outcome->matched);
  EXPECT_NEAR(outcome->T_map_base.raw().x(), 0.4, 1e-12);
  const auto seeing = slam.add_scan(room_scan(0.4, 3.5, 2.0), at(0.5));
  ASSERT_TRUE(seeing);
  EXPECT_TRUE(seeing->matched);
  EXPECT_NEAR(seeing->T_map_base.raw().x(), 0.5, 0.02);
}

TEST(GraphSlamBadInput, ARecordingMayStartWithoutReturns) {
  Recording recording;
  for (int k = 0; k < 5; ++k) {
    LaserScan blind = room_scan(0.2 * k, 3.0, 2.0);
    for (float& r : blind.ranges_m) r = 0.0F;
    recording.scans.push_back(blind);
  }
  for (int k = 5; k < 10; ++k) recording.scans.push_back(room_scan(0.2 * k, 3.0, 2.0));
  const auto slam = run_graph_slam(recording);
  ASSERT_TRUE(slam) << slam.error().to_string();
  EXPECT_EQ(slam->trajectory.size(), 10U);
}

TEST(GraphSlamBadInput, AStopRequestKeepsTheResultsSoFar) {
  Recording recording;
  for (int k = 0; k < 10; ++k) recording.scans.push_back(room_scan(0.2 * k, 3.0, 2.0));
  const auto slam = run_graph_slam(recording, {}, [](double done) { return done < 0.35; });
  ASSERT_TRUE(slam);
  EXPECT_EQ(slam->trajectory.size(), 4U);
}

}  // namespace
}  // namespace wayfare
