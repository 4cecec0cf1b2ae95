#include <wayfare/slam/radar_slam.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include <gtest/gtest.h>

#include "radar_slam_support.hpp"
#include "support.hpp"

namespace wayfare {
namespace {

// 40 s at 0.25 m/s. The drift of wheels and gyro alone is below this bound here, so the test is
// that no sensor makes it worse; drives that need the sensors are in radar_slam_study.
constexpr double kClose_m = 0.35;

TEST(RadarSlam, TracksWithEitherSensorAndBoth) {
  for (const SlamSensors sensors : {SlamSensors::radar, SlamSensors::lidar, SlamSensors::both}) {
    const RadarSlamRun slam = run(room(), sensors);
    EXPECT_LT(largest_error_m(slam.trajectory, room()), kClose_m);
    EXPECT_TRUE(slam.faults.empty()) << slam.faults.front().what;
    EXPECT_EQ(slam.refused_scans, 0U);
    EXPECT_EQ(slam.lidar_map.bounds().has_value(), sensors != SlamSensors::radar);
    EXPECT_EQ(slam.radar_map.bounds().has_value(), sensors != SlamSensors::lidar);
    EXPECT_GT(slam.statistics.matches, 10 * slam.statistics.matches_refused);
    EXPECT_EQ(slam.particles.size(), 8U);
  }
}

TEST(RadarSlam, GivesTheSameBytesForAnyNumberOfThreads) {
  const auto bytes = [](std::uint64_t seed, int threads) {
    RadarSlamOptions options = few();
    options.seed = seed;
    options.threads = threads;
    return bytes_of(run_radar_slam(room(), options, SlamSensors::both).value());
  };
  const RunBytes one = bytes(1, 1);
  ASSERT_FALSE(one.lidar.empty());
  ASSERT_FALSE(one.radar.empty());
  EXPECT_EQ(one, bytes(1, 1));
  EXPECT_EQ(one, bytes(1, 2));
  const RunBytes other = bytes(2, 1);
  EXPECT_NE(one.poses, other.poses);
  EXPECT_NE(one.lidar, other.lidar);
}

TEST(RadarSlam, RefusesInvalidMeasurements) {
  RadarSlam slam(few());
  LaserScan empty;
  EXPECT_FALSE(slam.add_lidar(empty));
  LaserScan turned = room_scan(0, 3, 2);
  turned.first_bearing = Angle::radians(std::numeric_limits<double>::quiet_NaN());
  EXPECT_FALSE(slam.add_lidar(turned));
  EXPECT_TRUE(slam.particles().empty());
  Gaussian<SE2d> lost{SE2d(), Eigen::Matrix3d::Identity()};
  lost.covariance(0, 0) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(slam.move(lost));
  EXPECT_FALSE(run_radar_slam(Recording(), {}, SlamSensors::both));
  LaserScan blind = room_scan(1, 3, 2);
  std::fill(blind.ranges_m.begin(), blind.ranges_m.end(), std::numeric_limits<float>::quiet_NaN());
  const auto outcome = slam.add_lidar(blind);
  ASSERT_TRUE(outcome);
  EXPECT_FALSE(outcome->updated);
  EXPECT_TRUE(slam.add_lidar(room_scan(2, 3, 2)));
}

}  // namespace
}  // namespace wayfare
