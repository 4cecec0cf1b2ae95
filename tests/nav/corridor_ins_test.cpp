// Accuracy of dead reckoning aided by corridor walls.

#include <wayfare/nav/corridor_ins.hpp>

#include <cmath>

#include <gtest/gtest.h>

#include <wayfare/sim/simulate_recording.hpp>

#include "corridor_ins/evaluate.hpp"

namespace wayfare {
namespace {

using examples::Aiding;

/// Shorter than the study's: a minute and a half in total.
sim::CorridorDriveParams params_of(sim::MotionPattern pattern) {
  sim::CorridorDriveParams p;
  p.pattern = pattern;
  p.rest_s = 30.0;
  p.speed_m_s = 1.0;
  p.gyro.drift_rad_s2 = 4e-5;
  return p;
}

CorridorRun run_of(const sim::CorridorDrive& drive, const CorridorInsOptions& options) {
  auto run = run_corridor_ins(drive.recording, motion_of(drive.recording), options);
  EXPECT_TRUE(run);
  return run ? *std::move(run) : CorridorRun{};
}

class CorridorInsOfPatterns : public testing::TestWithParam<sim::MotionPattern> {};
INSTANTIATE_TEST_SUITE_P(Patterns, CorridorInsOfPatterns,
                         testing::Values(sim::MotionPattern::straight, sim::MotionPattern::curved));

TEST_P(CorridorInsOfPatterns, BoundsThePositionAndEstimatesTheGyroBias) {
  const auto p = params_of(GetParam());
  const auto drive = sim::simulate_corridors(p, Rng(11));
  ASSERT_TRUE(drive);
  double rmse[3];
  for (const Aiding aiding : {Aiding::none, Aiding::side_walls, Aiding::end_walls}) {
    const auto errors =
        examples::errors_of(run_of(*drive, examples::options_for(p, aiding)), *drive, p.rest_s);
    rmse[aiding == Aiding::none         ? 0
         : aiding == Aiding::side_walls ? 1
                                        : 2] = errors.position_rmse_m[5];
    if (aiding == Aiding::none) continue;
    EXPECT_LT(std::abs(errors.bias_error_deg_s), 3 * errors.bias_sigma_deg_s);
    EXPECT_LT(std::abs(errors.scale_error), 3 * errors.scale_sigma);
    EXPECT_GT(errors.walls_share, 0.9);
  }
  EXPECT_LT(rmse[1], GetParam() == sim::MotionPattern::straight ? 0.25 : 0.10);
  EXPECT_LT(rmse[2], 0.10);
  EXPECT_GT(rmse[0], 5 * rmse[1]);
}

TEST(CorridorIns, NeedsAnEndWallToObserveTheDistanceAlong) {
  const auto p = params_of(sim::MotionPattern::straight);
  const auto drive = sim::simulate_corridors(p, Rng(12));
  double scale_left[2];
  for (const bool across : {false, true}) {
    const auto o = examples::options_for(p, across ? Aiding::end_walls : Aiding::side_walls);
    CorridorIns ins(o);
    const auto motion = motion_of(drive->recording);
    std::size_t next = 0;
    for (const LaserScan& scan : drive->recording.scans) {
      if (scan.time >= drive->section_ends[0]) break;
      for (; next < motion.size() && motion[next].time <= scan.time; ++next)
        ASSERT_TRUE(ins.add_motion(motion[next]));
      ASSERT_TRUE(ins.add_scan(scan));
    }
    scale_left[across ? 1 : 0] = ins.speed_scale().sigma / o.start_scale;
  }
  EXPECT_GT(scale_left[0], 0.9);  // unobservable in one straight corridor
  EXPECT_LT(scale_left[1], 0.15);
}

TEST(CorridorIns, DoorsObserveTheDistanceAlong) {
  auto p = params_of(sim::MotionPattern::straight);
  p.place.furniture.door_spacing_m = 3.0;
  p.speed_scale_sigma = 0.05;
  const auto drive = sim::simulate_corridors(p, Rng(12));
  ASSERT_TRUE(drive);
  const auto scale_left = [&](Aiding aiding) {
    const auto o = examples::options_for(p, aiding);
    CorridorIns ins(o);
    const auto motion = motion_of(drive->recording);
    std::size_t next = 0;
    for (const LaserScan& scan : drive->recording.scans) {
      if (scan.time >= drive->section_ends[0]) break;
      for (; next < motion.size() && motion[next].time <= scan.time; ++next)
        EXPECT_TRUE(ins.add_motion(motion[next]));
      EXPECT_TRUE(ins.add_scan(scan));
    }
    EXPECT_EQ(ins.report().marks_used > 50, aiding == Aiding::marks);
    EXPECT_LT(std::abs(ins.speed_scale().value - (1.0 / (1.0 + drive->speed_scale) - 1.0)),
              4.0 * ins.speed_scale().sigma);
    return ins.speed_scale().sigma / o.start_scale;
  };
  const double without = scale_left(Aiding::side_walls), with = scale_left(Aiding::marks);
  EXPECT_GT(without, 0.8);
  EXPECT_LT(with, 0.7 * without);
}

TEST(CorridorIns, IsDeterministic) {
  const auto p = params_of(sim::MotionPattern::curved);
  const auto drive = sim::simulate_corridors(p, Rng(13));
  const auto a = run_of(*drive, {}), b = run_of(*drive, {});
  EXPECT_EQ(a.epochs.back().pose.x(), b.epochs.back().pose.x());
  EXPECT_EQ(a.epochs.back().gyro_bias.value, b.epochs.back().gyro_bias.value);
}

TEST(CorridorIns, UsesScansAtALowerRate) {
  const auto p = params_of(sim::MotionPattern::curved);
  const auto drive = sim::simulate_corridors(p, Rng(13));
  auto options = examples::options_for(p, Aiding::side_walls);
  const CorridorRun all = run_of(*drive, options);
  options.least_scan_interval = from_seconds(1.0);  // scans are 0.2 s apart
  const CorridorRun some = run_of(*drive, options);
  EXPECT_EQ(some.epochs.size(), all.epochs.size());
  EXPECT_EQ(some.report.scans + some.report.skipped_scans, all.report.scans);
  EXPECT_NEAR(static_cast<double>(some.report.scans), 0.2 * static_cast<double>(all.report.scans),
              2.0);
  EXPECT_LT(examples::errors_of(some, *drive, p.rest_s).position_rmse_m[5], 0.2);
}

TEST(CorridorIns, CurveFittingInWindowsAidsToo) {
  const auto p = params_of(sim::MotionPattern::curved);
  const auto drive = sim::simulate_corridors(p, Rng(13));
  auto options = examples::options_for(p, Aiding::side_walls);
  options.search = WallSearch::windows;
  options.wall_direction_sigma_rad = 0.005;  // histograms have errors that their spread hides
  options.wall_offset_sigma_m = 0.01;
  const auto errors = examples::errors_of(run_of(*drive, options), *drive, p.rest_s);
  EXPECT_LT(errors.position_rmse_m[5], 0.5);
}

TEST(CorridorIns, AllWallsOfABuildingGiveTheHeading) {
  const auto p = params_of(sim::MotionPattern::straight);
  const auto drive = sim::simulate_corridors(p, Rng(17));
  // Heading errors of bad odometry: 0.05 rad in each sample of 50 ms.
  auto motion = motion_of(drive->recording);
  Rng rng(3);
  for (MotionSample& s : motion)
    if (std::abs(s.speed_m_s) > 0.0) s.turn_rate_rad_s += rng.normal(0.0, 1.0);
  auto options = examples::options_for(p, Aiding::side_walls);
  options.noise.angle_random_walk_rad_per_sqrt_s = 0.3;
  options.gyro_range_rad_s = 20.0;
  options.square_sigma_rad = 0.01;
  double rmse_deg[2];
  for (const bool building : {false, true}) {
    options.building_sigma_rad = building ? 0.03 : 0.0;
    const auto run = run_corridor_ins(drive->recording, motion, options);
    ASSERT_TRUE(run);
    EXPECT_EQ(run->report.headings_used > 0, building);
    rmse_deg[building ? 1 : 0] = examples::errors_of(*run, *drive, p.rest_s).heading_rmse_deg;
  }
  EXPECT_LT(rmse_deg[1], 3.0);
  EXPECT_LE(rmse_deg[1], rmse_deg[0]);
}

}  // namespace
}  // namespace wayfare
