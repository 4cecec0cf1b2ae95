// The corridors, the drives through them and their gyro.

#include <wayfare/sim/worlds.hpp>

#include <cmath>

#include <gtest/gtest.h>

#include <wayfare/core/geodesy.hpp>

namespace wayfare {
namespace {

sim::CorridorDriveParams quick(sim::MotionPattern pattern) {
  sim::CorridorDriveParams p;
  p.pattern = pattern;
  p.rest_s = 10.0;
  p.speed_m_s = 1.0;
  p.lidar.beams = 5;
  return p;
}

class Corridors : public testing::TestWithParam<sim::MotionPattern> {};
INSTANTIATE_TEST_SUITE_P(Patterns, Corridors,
                         testing::Values(sim::MotionPattern::straight, sim::MotionPattern::curved));

TEST_P(Corridors, AreDrivenAlongTheCentreLine) {
  const auto p = quick(GetParam());
  const auto drive = sim::simulate_corridors(p, Rng(1));
  ASSERT_TRUE(drive);
  const Trajectory& truth = drive->recording.truth;
  const SE2d end = truth.back().T_map_base.raw();
  // The centre line: 30 m along x, 30 m along y, 30 m along x.
  EXPECT_NEAR(end.x(), 60.0, 0.05);
  EXPECT_NEAR(end.y(), 30.0, 0.05);
  EXPECT_NEAR(end.heading().degrees(), 0.0, 0.5);
  for (const StampedPose& pose : truth)
    ASSERT_GT(drive->plan.clearance(pose.T_map_base.raw().translation(), 2.0), 0.5);
  EXPECT_EQ(drive->section_at(LogTime::from_seconds(5)), sim::CorridorSection::corridor_1);
  EXPECT_EQ(drive->section_at(drive->section_ends[0]), sim::CorridorSection::corner_1);
  EXPECT_EQ(drive->section_at(truth.back().time), sim::CorridorSection::corridor_3);
}

TEST_P(Corridors, GyroMeasuresRotationEarthRateAndBias) {
  auto p = quick(GetParam());
  p.gyro.angle_random_walk_rad_per_sqrt_s = 0.0;
  const auto drive = sim::simulate_corridors(p, Rng(2));
  ASSERT_TRUE(drive);
  ASSERT_EQ(drive->gyro_bias_rad_s.size(), drive->recording.gyro.size());
  const double earth = wgs84::kEarthRate_radps * std::sin(p.latitude_rad);
  double turned = 0.0;
  for (std::size_t i = 1; i < drive->recording.gyro.size(); ++i)
    turned += (drive->recording.gyro[i].turn_rate_rad_s - earth - drive->gyro_bias_rad_s[i]) *
              to_seconds(p.motion_period);
  EXPECT_NEAR(turned, 0.0, 1e-3);  // initial and final heading are equal
  const auto again = sim::simulate_corridors(p, Rng(2));
  EXPECT_EQ(again->recording.gyro.back().turn_rate_rad_s,
            drive->recording.gyro.back().turn_rate_rad_s);
  EXPECT_EQ(again->recording.scans.back().ranges_m, drive->recording.scans.back().ranges_m);
}

TEST(Corridors, WheelsHaveAScaleError) {
  auto p = quick(sim::MotionPattern::straight);
  p.slip_m_per_sqrt_m = 0.0;
  const auto drive = sim::simulate_corridors(p, Rng(3));
  double reported = 0.0, rolled = 0.0;
  for (const WheelSample& w : drive->recording.wheels) reported += 0.5 * (w.left_m + w.right_m);
  const Trajectory& truth = drive->recording.truth;
  for (std::size_t i = 1; i < truth.size(); ++i)
    rolled +=
        (truth[i].T_map_base.raw().translation() - truth[i - 1].T_map_base.raw().translation())
            .norm();
  EXPECT_NE(drive->speed_scale, 0.0);
  EXPECT_NEAR(reported / rolled - 1.0, drive->speed_scale, 1e-4);
}

TEST(Corridors, StayPassableWithFurniture) {
  auto p = quick(sim::MotionPattern::straight);
  p.place.furniture = {.door_spacing_m = 3.0,
                       .open_share = 0.5,
                       .boxes_per_m = 0.2,
                       .people_per_m = 0.1,
                       .glass_per_m = 0.03};
  const auto drive = sim::simulate_corridors(p, Rng(4));
  ASSERT_TRUE(drive);
  const auto plain = sim::three_corridors({}, Rng(4));
  EXPECT_GT(drive->plan.segments().size(), plain->segments().size() + 100);
  for (const StampedPose& pose : drive->recording.truth)
    ASSERT_GT(drive->plan.clearance(pose.T_map_base.raw().translation(), 2.0), 0.4);
}

}  // namespace
}  // namespace wayfare
