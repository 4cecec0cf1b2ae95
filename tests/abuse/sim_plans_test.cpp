// Plans, robots, lasers and radars of the simulation with geometry and parameters that are none.

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include <wayfare/core/random.hpp>
#include <wayfare/sim/differential_drive.hpp>
#include <wayfare/sim/floor_plan.hpp>
#include <wayfare/sim/lidar_2d.hpp>
#include <wayfare/sim/radar.hpp>
#include <wayfare/sim/simulate_recording.hpp>
#include <wayfare/sim/worlds.hpp>

#include "abuse/abuse.hpp"

namespace wayfare::tests {
namespace {

using namespace wayfare::sim;
using Eigen::Vector2d;

constexpr std::int64_t kLast = std::numeric_limits<std::int64_t>::max();

std::vector<Segment> box(double half) {
  return {{{-half, -half}, {half, -half}},
          {{half, -half}, {half, half}},
          {{half, half}, {-half, half}},
          {{-half, half}, {-half, -half}}};
}
FloorPlan plan_of(double half) { return FloorPlan::from_segments(box(half)).value(); }

TEST(FloorPlanAbuse, WallsThatAreNoneAreNamed) {
  EXPECT_FALSE(FloorPlan::from_segments({}));
  for (const double odd : {kNan, kInf, -kInf, kHuge, 1e9}) {
    auto walls = box(1.0);
    walls[2].b_m.y() = odd;
    const auto plan = FloorPlan::from_segments(walls);
    ASSERT_FALSE(plan);
    EXPECT_NE(plan.error().message.find("wall 2"), std::string::npos);
    EXPECT_FALSE(FloorPlan::from_cells({2, 2, odd, {1, 0, 0, 1}}));
    EXPECT_FALSE(plan_from_picture(std::vector<std::uint8_t>(4, 0), 2, 2, odd));
  }
  constexpr int kMost = std::numeric_limits<int>::max();
  for (const int side : {-1, 0, 3, kMost, std::numeric_limits<int>::min()}) {
    EXPECT_FALSE(FloorPlan::from_cells({side, 2, 0.1, {1, 0, 0, 1}}));
    EXPECT_FALSE(FloorPlan::from_cells({side, side, 0.1, {1, 0, 0, 1}}));
    EXPECT_FALSE(plan_from_picture(std::vector<std::uint8_t>(4, 0), 2, side, 0.1));
  }
}

TEST(FloorPlanAbuse, RaysFromAndAlongAnythingEnd) {
  Rng rng(1);
  const FloorPlan small = plan_of(3.0), large = plan_of(1e5);
  const auto number = [&] {
    constexpr std::array kOdd{kNan, kInf, -kInf, kHuge, -kHuge, kTiny, 0.0, 1e9, 3.0};
    return rng.below(3) == 0 ? kOdd[rng.below(kOdd.size())] : rng.uniform(-4.0, 4.0);
  };
  for (int i = 0; i < 20000; ++i) {
    const FloorPlan& plan = rng.below(2) == 0 ? small : large;
    const Vector2d a(number(), number()), b(number(), number());
    const double reach = number();
    const double hit = plan.cast(a, b, reach);
    ASSERT_TRUE(hit >= 0.0 && (std::isinf(hit) || hit <= reach))
        << a.transpose() << " " << b.transpose();
    const double near = plan.clearance(a, reach);
    ASSERT_TRUE(near >= 0.0 && (std::isinf(near) || near <= reach));
    if (!a.allFinite() || !b.allFinite()) {
      ASSERT_FALSE(plan.blocks(a, b));
    }
    if (!a.allFinite()) {
      ASSERT_TRUE(std::isinf(hit) && std::isinf(near));
    }
  }
}

TEST(FloorPlanAbuse, LeaksAndMapsOfPointsThatAreNone) {
  const FloorPlan plan = plan_of(3.0);
  EXPECT_FALSE(find_leak(plan, {0, 0}));
  for (const double odd : {kNan, kInf, kHuge, 1e9}) {
    EXPECT_TRUE(find_leak(plan, {odd, 0.0}));
    EXPECT_FALSE(map_of_plan(plan, {odd, 0.0}));
  }
  EXPECT_FALSE(map_of_plan(plan, {3.0, 3.0}));
  EXPECT_FALSE(map_of_plan(plan_of(1e5), {0, 0}));
  OccupancyGridOptions fine;
  fine.resolution_m = 1e-9;
  EXPECT_FALSE(map_of_plan(plan, {0, 0}, fine));
}

TEST(FloorPlanAbuse, TextsThatAreNoPlanHaveALine) {
  for (const std::string text : {"", "\n\n", "wall 0 0 nan 1", "wall 0 0 inf 1", "wall 0 0 1e9 1",
                                 "metres_per_character nan\npicture\n#", "picture\n#", "route a",
                                 "metres_per_character 1\npicture\n", "place a 1e300 0",
                                 "wall 0 0 1 1\nroute nowhere", "wall", "\0wall 1"})
    EXPECT_FALSE(read_plan(text)) << text;
  std::string wide = "metres_per_character 1\npicture\n" + std::string(100'000, '#');
  EXPECT_FALSE(read_plan(wide));
  const std::string demo(demo_building().substr(0, 3000));
  Rng rng(2);
  for (int i = 0; i < 2000; ++i) {
    std::string text = demo;
    for (std::uint64_t n = rng.below(5); n > 0; --n)
      text[rng.below(text.size())] = static_cast<char>(rng());
    const auto plan = read_plan(text.substr(0, rng.below(text.size())));
    if (!plan) {
      ASSERT_EQ(plan.error().source, "plan");
      continue;
    }
    for (const Vector2d& p : plan->route_m) ASSERT_TRUE(p.allFinite());
  }
}

TEST(DriveAbuse, RoutesThatCannotBeDrivenAreErrors) {
  DriveParams hurried;
  hurried.timeout = std::chrono::seconds(20);
  for (const double odd : kNotFinite)
    EXPECT_FALSE(drive_route(std::vector<Vector2d>{{0, 0}, {odd, 0}}, hurried));
  for (const double far : {1e9, kHuge})
    EXPECT_FALSE(drive_route(std::vector<Vector2d>{{0, 0}, {far, 0}}, hurried));
  EXPECT_FALSE(drive_route(std::vector<Vector2d>{{0, 0}}, hurried));
  EXPECT_FALSE(drive_route({}, hurried));
  EXPECT_EQ(drive_route(std::vector<Vector2d>(5, {1, 1}), hurried)->size(), 1U);
  hurried.heading_gain_per_s = kNan;
  EXPECT_FALSE(drive_route(std::vector<Vector2d>{{0, 0}, {9, 9}}, hurried));
}

Trajectory jump(std::int64_t ns) {
  Trajectory t;
  for (int i = 0; i < 10; ++i)
    t.push_back({LogTime::from_nanoseconds(i * 10'000'000),
                 Transform2<frame::Map, frame::Base>(SE2d(0.01 * i, 0, Angle{}))});
  t.push_back({LogTime::from_nanoseconds(ns), Transform2<frame::Map, frame::Base>(SE2d())});
  return t;
}

TEST(DriveAbuse, SensorsOfATruthWithAGapOfYearsEnd) {
  for (const std::int64_t ns : {std::int64_t{1'000'000'000'000'000'000}, kLast}) {
    Rng rng(1);
    const auto wheels = simulate_wheels(jump(ns), Duration(20'000'000), {}, rng);
    const auto gyro = simulate_gyro(jump(ns), Duration(20'000'000), {}, rng);
    EXPECT_LT(wheels.size(), 10U);
    EXPECT_EQ(wheels.size(), gyro.size());
    for (const WheelSample& w : wheels) EXPECT_TRUE(std::isfinite(w.left_m));
    for (const GyroSample& g : gyro) EXPECT_TRUE(std::isfinite(g.turn_rate_rad_s));
    EXPECT_EQ(dead_reckon(wheels, gyro).size(), wheels.size());
    EXPECT_EQ(true_pose_at(jump(ns), LogTime::from_nanoseconds(-kLast)).x(), 0.0);
  }
  Rng rng(1);
  EXPECT_TRUE(simulate_wheels({}, Duration(1), {}, rng).empty());
  EXPECT_TRUE(simulate_gyro({}, Duration(1), {}, rng).empty());
  EXPECT_TRUE(dead_reckon({}, 0.4).empty());
}

TEST(RecordingAbuse, PartsKeepTheSensorsAndEndAtTheRange) {
  Recording recording;
  recording.radar_max_speed_m_s = 2.5;
  recording.wheel_base_m = 0.4;
  recording.wheels = {{LogTime::from_nanoseconds(-kLast), 1, 1},
                      {LogTime{}, 1, 1},
                      {LogTime::from_nanoseconds(kLast - 1), 1, 1}};
  const LogTime from = LogTime::from_nanoseconds(-kLast), to = LogTime::from_nanoseconds(kLast);
  EXPECT_EQ(part_of(recording, from, to).wheels.size(), 3U);
  EXPECT_EQ(part_of(recording, from, to).radar_max_speed_m_s, 2.5);
  EXPECT_TRUE(part_of(recording, to, from).wheels.empty());
  EXPECT_EQ(kidnapped(recording, LogTime{}, LogTime{}).wheels.size(), 3U);
  EXPECT_EQ(kidnapped(recording, from, to).radar_max_speed_m_s, 2.5);
  EXPECT_TRUE(kidnapped({}, from, to).wheels.empty());
}

TEST(LidarAbuse, PosesThatAreNoneSeeNothing) {
  const FloorPlan plan = plan_of(3.0);
  Rng rng(1);
  for (const double odd : {kNan, kInf, kHuge, 1e9}) {
    const LaserScan scan = simulate_scan(
        plan, [&](LogTime) { return SE2d(odd, 0.0, Angle{}); }, LogTime{}, full_circle(90), rng);
    for (const float r : scan.ranges_m) EXPECT_EQ(r, 30.0F);
  }
  Lidar2dParams none = full_circle(1);
  none.beams = 0;
  none.sweep = Duration::max();
  EXPECT_TRUE(simulate_scan(
                  plan, [](LogTime) { return SE2d(); }, LogTime{}, none, rng)
                  .ranges_m.empty());
  none.beams = 3;
  EXPECT_EQ(simulate_scan(
                plan, [](LogTime) { return SE2d(); }, LogTime::from_nanoseconds(kLast), none, rng)
                .ranges_m.size(),
            3U);
}

TEST(RadarAbuse, ReflectorsAndVelocitiesThatAreNoneHaveNoEcho) {
  const FloorPlan plan = plan_of(4.0);
  const auto frame = [&](const std::vector<Reflector>& reflectors, const SE2d& pose,
                         const Vector2d& velocity) {
    Rng rng(3);
    return simulate_radar(plan, reflectors, pose, velocity, LogTime{}, {}, rng).points;
  };
  const Reflector good{.at_m = {2.0, 0.5}, .strength_db = 60.0};
  const auto empty = frame({}, SE2d(), {0, 0});
  EXPECT_NE(frame({good}, SE2d(), {0.1, 0}), empty);
  for (const double odd : {kNan, kInf, -kInf, kHuge, 1e12}) {
    EXPECT_EQ(frame({good}, SE2d(), {odd, 0}), empty) << odd;
    if (odd != 1e12) {
      EXPECT_EQ(frame({good}, SE2d(odd, 0, Angle{}), {0, 0}), empty) << odd;
    }
    Reflector r = good;
    r.at_m.y() = odd;
    EXPECT_EQ(frame({r}, SE2d(), {0, 0}), empty);
    r = good;
    r.strength_db = odd;
    if (odd != 1e12) {
      EXPECT_EQ(frame({r}, SE2d(), {0, 0}), empty) << odd;
    }
  }
  Reflector ghost = good;
  for (const std::uint32_t mirror : {4U, 0xfffffffeU}) {
    ghost.mirror = mirror;
    EXPECT_EQ(frame({ghost}, SE2d(), {0, 0}), empty);
  }
}

TEST(RadarDeathTest, CellsHaveALimit) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  Rng rng(1);
  const FloorPlan plan = plan_of(4.0);
  for (const auto change :
       {+[](RadarParams& p) { p.doppler_bins = 16384; },
        +[](RadarParams& p) { p.max_range_m = 1e9; }, +[](RadarParams& p) { p.min_range_m = kNan; },
        +[](RadarParams& p) { p.azimuth_bins = 1'000'000'000; }}) {
    RadarParams params;
    change(params);
    EXPECT_DEATH((void)simulate_radar(plan, {}, SE2d(), {0, 0}, LogTime{}, params, rng), "cells");
  }
  EXPECT_DEATH((void)furnish(plan_of(1e5), {}, {}, rng), "reflectors");
}

TEST(WorldsAbuse, VoxelsAndPathsThatAreNoneAreNamed) {
  std::vector<Eigen::Vector3d> voxels, path;
  for (int i = 0; i < 60; ++i)
    for (const double z : {0.0, 0.1}) voxels.emplace_back(0.15 * i, 3.0, z);
  for (int i = 0; i < 10; ++i) path.emplace_back(1.0 * i, 0.0, 0.0);
  VoxelWorldParams params;
  ASSERT_TRUE(world_of_voxels(voxels, path, params, Rng(1)));
  for (const double odd : {kNan, kInf, -kInf, kHuge, 1e9}) {
    auto bad = voxels;
    bad[7].x() = odd;
    EXPECT_FALSE(world_of_voxels(bad, path, params, Rng(1))) << odd;
    auto lost = path;
    lost[3].y() = odd;
    EXPECT_FALSE(world_of_voxels(voxels, lost, params, Rng(1))) << odd;
  }
  voxels[7].z() = kNan;
  EXPECT_FALSE(world_of_voxels(voxels, path, params, Rng(1)));
  voxels[7].z() = 1e9;  // above the slice
  EXPECT_TRUE(world_of_voxels(voxels, path, params, Rng(1)));
  for (const double size : {0.0, -1.0, kNan, kTiny}) {
    VoxelWorldParams tiny;
    tiny.voxel_m = size;
    EXPECT_FALSE(world_of_voxels(voxels, path, tiny, Rng(1))) << size;
  }
  EXPECT_FALSE(world_of_voxels(voxels, {}, params, Rng(1)));
  EXPECT_FALSE(make_world("", Rng(1)));
}

TEST(CorridorsAbuse, DrivesThatNeverEndAreRefused) {
  for (const double odd : {0.0, -1.0, kNan, kInf, 1e9, kTiny}) {
    for (double CorridorDriveParams::*number :
         {&CorridorDriveParams::speed_m_s, &CorridorDriveParams::acceleration_m_s2,
          &CorridorDriveParams::corner_radius_m}) {
      CorridorDriveParams p;
      p.*number = odd;
      p.scan_period = std::chrono::seconds(100);
      const bool works = odd >= 1e9 && number != &CorridorDriveParams::corner_radius_m;
      const bool sharp = odd == kTiny && number == &CorridorDriveParams::corner_radius_m;
      if (!works && !sharp) {
        EXPECT_FALSE(simulate_corridors(p, Rng(1))) << odd;
      }
    }
    CorridorDriveParams p;
    p.place.lengths_m[1] = odd;
    EXPECT_FALSE(simulate_corridors(p, Rng(1))) << odd;
    p = {};
    p.rest_s = odd == 0.0 || odd == kTiny ? -2.0 : odd;
    EXPECT_FALSE(simulate_corridors(p, Rng(1))) << odd;
    CorridorsParams place;
    place.furniture.boxes_per_m = odd == 0.0 || odd == kTiny ? -2.0 : odd;
    EXPECT_FALSE(three_corridors(place, Rng(1))) << odd;
  }
  CorridorsParams doors;
  doors.furniture.door_spacing_m = kTiny;
  EXPECT_FALSE(three_corridors(doors, Rng(1)));
  CorridorDriveParams p;
  p.motion_period = Duration::zero();
  EXPECT_FALSE(simulate_corridors(p, Rng(1)));
}

TEST(SimPlansAbuse, TwoThreadsSimulateTheSame) {
  const auto both = in_two_threads([](int) {
    const FloorPlan plan = plan_of(4.0);
    const auto run =
        simulate_recording(plan, std::vector<Vector2d>{{-2, 0}, {2, 0}, {2, 2}}, {}, Rng(5));
    std::vector<float> all = run.value().recording.scans.back().ranges_m;
    Rng rng(6);
    const auto reflectors = furnish(plan, {}, {}, rng);
    for (const RadarPoint& p :
         simulate_radar(plan, reflectors, SE2d(), {0.2, 0}, LogTime{}, {}, rng).points)
      all.push_back(p.x_m + p.doppler_m_s);
    return all;
  });
  EXPECT_EQ(both[0], both[1]);
}

}  // namespace
}  // namespace wayfare::tests
