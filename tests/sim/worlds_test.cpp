#include <wayfare/sim/worlds.hpp>

#include <algorithm>
#include <cmath>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <wayfare/io/carmen.hpp>
#include <wayfare/io/map_image.hpp>

#include "io/support.hpp"

namespace wayfare::sim {
namespace {

// The first metres of a world's route, for a tenth of the time.
World beginning(std::string_view name, std::uint64_t seed) {
  World world = std::move(make_world(name, Rng(seed))).value();
  world.route_m.resize(2);
  const Eigen::Vector2d leg = world.route_m[1] - world.route_m[0];
  world.route_m[1] = world.route_m[0] + 2.5 * leg.normalized();
  return world;
}

Recording run(const World& world, std::uint64_t seed) {
  const Rng rng(seed);
  auto recording = simulate_world(world, turtlebot(rng), rng);
  EXPECT_TRUE(recording.has_value()) << recording.error().to_string();
  return recording ? std::move(*recording) : Recording{};
}

TEST(Worlds, UnknownNamesAreRefusedWithTheKnownOnes) {
  const auto world = make_world("attic", Rng(1));
  ASSERT_FALSE(world.has_value());
  EXPECT_THAT(world.error().message, ::testing::HasSubstr("corridor_loop"));
}

TEST(Worlds, EveryWorldCanBeDriven) {
  for (const WorldName& name : world_names()) {
    const World world = std::move(make_world(name.name, Rng(4))).value();
    WorldRobot robot = turtlebot(Rng(4));
    robot.robot.scan_period = robot.radar.period = std::chrono::seconds(20);
    const auto recording = simulate_world(world, robot, Rng(4));
    ASSERT_TRUE(recording.has_value()) << name.name << ": " << recording.error().to_string();
    const Eigen::Vector2d end = recording->truth.back().T_map_base.raw().translation();
    EXPECT_LT((end - world.route_m.back()).norm(), 0.3) << name.name;
  }
}

TEST(Worlds, StreamsHaveTheirRates) {
  const Recording r = run(beginning("corridor_loop", 2), 2);
  const double length_s = to_seconds(r.truth.back().time - r.truth.front().time);
  ASSERT_GT(length_s, 8.0);
  EXPECT_NEAR(static_cast<double>(r.radar.size()), 30.0 * length_s, 2.0);
  EXPECT_NEAR(static_cast<double>(r.scans.size()), 5.0 * length_s, 2.0);
  EXPECT_NEAR(static_cast<double>(r.wheels.size()), 20.0 * length_s, 2.0);
  EXPECT_EQ(r.gyro.size(), r.wheels.size());
  for (const RadarScan& scan : r.radar) EXPECT_LE(scan.points.size(), 100U);
  for (const LaserScan& scan : r.scans) EXPECT_EQ(scan.ranges_m.size(), 360U);
}

TEST(Worlds, AreDeterminedByTheSeed) {
  const World world = beginning("room", 3);
  const std::string a = io::format_carmen(run(world, 3));
  EXPECT_EQ(a, io::format_carmen(run(beginning("room", 3), 3)));
  EXPECT_NE(a, io::format_carmen(run(world, 4)));
}

TEST(Worlds, TheRadarDoesNotChangeTheOtherSensors) {
  const World world = beginning("room", 3);
  WorldRobot robot = turtlebot(Rng(3)), blind = robot;
  blind.radar.radar.max_points = 0;
  auto a = simulate_world(world, robot, Rng(3)), b = simulate_world(world, blind, Rng(3));
  ASSERT_TRUE(a.has_value() && b.has_value());
  a->radar.clear();
  b->radar.clear();
  EXPECT_EQ(io::format_carmen(*a), io::format_carmen(*b));
}

// A corridor of voxels, 6 m x 1.8 m with both ends open, and a box across it.
TEST(Worlds, VoxelsBecomeAWorldThatCanBeDriven) {
  std::vector<Eigen::Vector3d> voxels, path;
  for (double x = 0.075; x < 6.0; x += 0.15) {
    for (const double z : {-0.075, 0.075}) {
      voxels.emplace_back(x, 0.075, z);
      voxels.emplace_back(x, 1.875, z);
    }
    voxels.emplace_back(x, 0.975, 2.0);  // the ceiling, above the slice
  }
  for (const double z : {-0.075, 0.075}) voxels.emplace_back(3.075, 0.975, z);
  for (double x = 0.6; x < 5.4; x += 0.1) path.emplace_back(x, 0.97, 0.0);
  const auto world = world_of_voxels(voxels, path, {}, Rng(1));
  ASSERT_TRUE(world.has_value()) << world.error().to_string();
  const auto recording = simulate_world(*world, turtlebot(Rng(1)), Rng(1));
  ASSERT_TRUE(recording.has_value()) << recording.error().to_string();
  const Eigen::Vector2d driven = recording->truth.back().T_map_base.raw().translation() -
                                 recording->truth.front().T_map_base.raw().translation();
  EXPECT_NEAR(driven.x(), 4.7, 0.5);
  // Walls 0.9 m to either side, whose near faces in cells are 0.825 m away.
  const LaserScan& scan = recording->scans[recording->scans.size() / 2];
  for (const std::size_t beam : {90U, 270U}) EXPECT_NEAR(scan.ranges_m[beam], 0.82F, 0.15F);
}

// The carrier's path is free, has walls in sight, and can be driven.
TEST(Worlds, ARealBuildingCanBeDriven) {
  WAYFARE_NEEDS_RECORDING(map,
                          "radar/coloradar_rmap/data/maps/ec_hallways_run0_lidar_filtered.txt.gz");
  WAYFARE_NEEDS_RECORDING(poses, "radar/coloradar_rmap/data/poses/ec_hallways_run0.txt");
  const auto voxels = io::read_points(map), path = io::read_points(poses);
  ASSERT_TRUE(voxels.has_value() && path.has_value());
  auto world = world_of_voxels(voxels->points_m, path->points_m, {}, Rng(1));
  ASSERT_TRUE(world.has_value()) << world.error().to_string();
  ASSERT_GT(world->route_m.size(), 50U);
  std::size_t in_sight = 0;
  for (const Eigen::Vector2d& place : world->route_m) {
    double nearest = 1e9;
    for (int k = 0; k < 36; ++k) {
      const double a = 0.1745 * k;
      nearest = std::min(nearest, world->plan.cast(place, {std::cos(a), std::sin(a)}, 6.0));
    }
    EXPECT_GT(nearest, 0.3) << place.transpose();
    in_sight += nearest < 3.0 ? 1 : 0;
  }
  EXPECT_GT(in_sight, world->route_m.size() * 9 / 10);
  world->route_m.resize(4);
  const Recording recording = run(*world, 1);
  std::size_t points = 0;
  for (const RadarScan& scan : recording.radar) points += scan.points.size();
  EXPECT_GT(points, 30 * recording.radar.size());
}

TEST(Worlds, VoxelsWithoutAPathAreRefused) {
  const std::vector<Eigen::Vector3d> one = {{1.0, 1.0, 0.0}};
  EXPECT_FALSE(world_of_voxels(one, one, {}, Rng(1)).has_value());
  EXPECT_FALSE(world_of_voxels({}, {}, {}, Rng(1)).has_value());
}

// On the carpet the wheels report 2 % too much. Slip over 4 m at 3 * 0.006 m/sqrt(m) is 0.036 m per
// wheel, 0.026 m of their mean; bound at 4 sigma.
TEST(Worlds, CarpetMakesWheelsReportTooMuch) {
  Trajectory truth;
  for (int i = 0; i <= 400; ++i) {
    const SE2d pose(0.01 * i, 0.0, Angle{});
    truth.push_back({LogTime::from_seconds(0.05 * i), Transform2<frame::Map, frame::Base>(pose)});
  }
  WheelParams params;
  params.slip_m_per_sqrt_m = 0.006;
  params.carpets.push_back({{-1.0, -1.0}, {5.0, 1.0}});
  Rng rng(1);
  double rolled = 0.0;
  for (const WheelSample& w : simulate_wheels(truth, Duration(50'000'000), params, rng))
    rolled += 0.5 * (w.left_m + w.right_m);
  EXPECT_NEAR(rolled, 4.0 * 1.02, 4.0 * 0.026);
}

}  // namespace
}  // namespace wayfare::sim
