// The particle filter where the robot is carried to another place.

#include <cstddef>

#include <gtest/gtest.h>

#include <wayfare/slam/radar_slam.hpp>

#include "carried.hpp"
#include "radar_slam_support.hpp"
#include "support.hpp"

namespace wayfare {
namespace {

RadarSlamOptions filter_options(int threads = 1) {
  RadarSlamOptions options = few();
  options.particles = 4;
  options.threads = threads;
  return options;
}

/// The second half begins elsewhere; both see the whole flat.
const sim::SimulatedRun& carried_run() {
  static const sim::SimulatedRun run =
      carried(simulate(kFlat, slipping_robot(), 1), {{0.5, 1.0}, {0.0, 0.5}});
  return run;
}

TEST(RadarSlamPieces, AreOneMapWhereTheyAreFoundAgain) {
  const auto slam = run_radar_slam(carried_run().recording, filter_options(), SlamSensors::lidar);
  ASSERT_TRUE(slam) << slam.error().to_string();
  EXPECT_EQ(slam->statistics.pieces, 2U);
  EXPECT_EQ(slam->statistics.odometry_leaps, 1U);
  EXPECT_EQ(slam->statistics.joins, 1U);
  EXPECT_EQ(slam->statistics.pieces_apart, 0U);
  EXPECT_EQ(slam->trajectory.size(), carried_run().recording.scans.size());
  EXPECT_LT(rmse_m(slam->trajectory, carried_run().truth), 0.15);
  EXPECT_LT(slam->crossings.share, 0.05);
  const auto threads =
      run_radar_slam(carried_run().recording, filter_options(3), SlamSensors::lidar);
  ASSERT_TRUE(threads) << threads.error().to_string();
  EXPECT_EQ(bytes_of(*threads), bytes_of(*slam));
}

// A robot that is set down in a place not seen before: beside the map, whose cells stay.
TEST(RadarSlamPieces, StayApartWhereTheyAreNotFound) {
  const sim::SimulatedRun run =
      carried(simulate(kFlat, slipping_robot(), 1), {{0.0, 0.08}, {0.22, 0.34}});
  const auto slam = run_radar_slam(run.recording, filter_options(), SlamSensors::lidar);
  ASSERT_TRUE(slam) << slam.error().to_string();
  EXPECT_EQ(slam->statistics.pieces_apart, 1U);
  EXPECT_EQ(slam->statistics.joins, 0U);
  ASSERT_EQ(slam->trajectory.size(), run.recording.scans.size());
  EXPECT_GT(slam->trajectory.back().T_map_base.raw().x(), 30.0);
  ASSERT_TRUE(slam->lidar_map.bounds());
  EXPECT_GT(slam->lidar_map.bounds()->max.x * slam->lidar_map.resolution_m(), 30.0);
}

TEST(RadarSlamPieces, OfASymmetricBuildingStayApart) {
  const sim::SimulatedRun run =
      carried(simulate(kSymmetric, slipping_robot(), 2), {{0.0, 0.55}, {0.68, 1.0}});
  const auto slam = run_radar_slam(run.recording, filter_options(), SlamSensors::lidar);
  ASSERT_TRUE(slam) << slam.error().to_string();
  EXPECT_EQ(slam->statistics.joins, 0U);
  EXPECT_EQ(slam->statistics.pieces_apart, 1U);
}

}  // namespace
}  // namespace wayfare
