#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include <wayfare/sim/walks.hpp>
#include <wayfare/slam/hector_slam.hpp>

#include "sim/support.hpp"

namespace wayfare {
namespace {

/// From one room to another and back on a person's head.
struct Walked {
  MargRecording unit;
  Recording recording;
};

Walked walk_through_the_office(std::uint64_t seed) {
  const sim::PlannedRoute planned_route = planned(kOffice);
  std::vector<Eigen::Vector2d> route = planned_route.route_m;
  route.push_back(route.front());
  Rng rng(seed);
  const sim::HeadWalk head(route, {.pitch = Angle::degrees(5), .roll = Angle::degrees(4)},
                           rng.stream(1));
  Walked walked;
  walked.unit = head.unit(100.0, {.accel_bias_mps2 = 0.03}, rng);
  for (double t = 1.0; t < head.duration_s(); t += 1 / 5.5) {
    const auto pose = head.at(t);
    const auto time = LogTime::from_seconds(t);
    CarrierState truth;
    truth.position_m = pose.position_m;
    truth.q_map_body = pose.q_world_head;
    walked.recording.truth.push_back({time, Transform2<frame::Map, frame::Base>(truth.planar())});
    walked.recording.scans.push_back(sim::scan_from_head(planned_route.plan, pose, time, {}, rng));
  }
  return walked;
}

double worst_m(const Trajectory& found, const Trajectory& truth, double from_s = 0.0) {
  double worst = 0.0;
  for (std::size_t i = 0; i < found.size(); ++i) {
    const SE2d want = truth[0].T_map_base.raw().inverse() * truth[i].T_map_base.raw();
    if (found[i].time.seconds() >= from_s)
      worst =
          std::max(worst, (found[i].T_map_base.raw().translation() - want.translation()).norm());
  }
  return worst;
}

// With the laser mounted where no cell has a number.
TEST(HectorSlamWithUnit, ARefusedFirstScanIsNotCounted) {
  HectorSlamOptions options;
  options.T_base_laser = Transform2<frame::Base, frame::Laser>(SE2d(1e12, 0.0, Angle()));
  HectorSlam slam(options);
  LogTime time;
  for (int i = 0; i < 300; ++i, time += std::chrono::milliseconds(10))
    slam.add(ImuSample{time, Eigen::Vector3d::Zero(), {0.0, 0.0, 9.81}});
  const LaserScan scan{time,  Angle::degrees(-180),         Angle::degrees(1), 0.05F,
                       10.0F, std::vector<float>(360, 2.0F)};
  ASSERT_TRUE(slam.carrier().covers(time));
  EXPECT_FALSE(slam.add_scan(scan, std::nullopt));
  EXPECT_EQ(slam.statistics().levelled_scans, 0U);
  EXPECT_EQ(slam.statistics().scans, 0U);
  EXPECT_TRUE(slam.trajectory().empty());
}

TEST(HectorSlamWithUnit, TracksATiltingHead) {
  for (const std::uint64_t seed : {1U, 2U}) {
    const Walked w = walk_through_the_office(seed);
    const auto run = run_hector_slam(w.recording, w.unit);
    ASSERT_TRUE(run) << run.error().to_string();
    EXPECT_LT(worst_m(run->trajectory, w.recording.truth), 0.15) << seed;
    EXPECT_EQ(run->statistics.levelled_scans, w.recording.scans.size());
    EXPECT_GT(run->statistics.fused_scans, w.recording.scans.size() * 9 / 10);
    EXPECT_EQ(run->statistics.carrier_starts, 1U);
  }
}

TEST(HectorSlamWithUnit, SurvivesAnInterruptionOfTheUnit) {
  Walked w = walk_through_the_office(3);
  std::erase_if(w.unit, [](const MargSample& s) {
    return s.time.seconds() > 9.0 && s.time.seconds() < 12.0;
  });
  const auto run = run_hector_slam(w.recording, w.unit);
  ASSERT_TRUE(run);
  EXPECT_EQ(run->statistics.carrier_starts, 2U);
  EXPECT_LT(run->statistics.levelled_scans, w.recording.scans.size() - 10);
  EXPECT_LT(worst_m(run->trajectory, w.recording.truth), 0.5);
}

// Every fourth scan is missing, others come twice; samples have gaps of 0.15 s.
TEST(HectorSlamWithUnit, SurvivesIrregularScansAndSamples) {
  Walked w = walk_through_the_office(2);
  Rng rng(4);
  std::vector<LaserScan> scans;
  Trajectory truth;
  for (std::size_t i = 0; i < w.recording.scans.size(); ++i) {
    if (i > 0 && rng.below(4) == 0) continue;
    scans.push_back(w.recording.scans[i]);
    truth.push_back(w.recording.truth[i]);
    if (i % 10 != 9) continue;
    scans.push_back(scans.back());
    truth.push_back(truth.back());
  }
  w.recording.scans = scans;
  std::erase_if(w.unit,
                [](const MargSample& s) { return std::fmod(s.time.seconds(), 3.0) < 0.15; });
  const auto run = run_hector_slam(w.recording, w.unit);
  ASSERT_TRUE(run);
  EXPECT_EQ(run->refused_scans, 0U);
  ASSERT_EQ(run->trajectory.size(), truth.size());
  EXPECT_LT(worst_m(run->trajectory, truth), 0.3);
}

// Five seconds without returns and round a corner by the filter alone, with a metre of error at the
// end; then the walls are matched again.
TEST(HectorSlamWithUnit, CoastsWithoutReturns) {
  Walked w = walk_through_the_office(4);
  for (LaserScan& scan : w.recording.scans)
    if (scan.time.seconds() > 8.0 && scan.time.seconds() < 13.0)
      for (float& range : scan.ranges_m) range = std::numeric_limits<float>::quiet_NaN();
  const auto run = run_hector_slam(w.recording, w.unit);
  ASSERT_TRUE(run);
  EXPECT_GT(run->statistics.unmatched_scans, 20U);
  EXPECT_LT(worst_m(run->trajectory, w.recording.truth, 15.0), 0.3);
}

TEST(HectorSlamWithUnit, AUnitWithoutSamplesChangesNothing) {
  Walked w = walk_through_the_office(1);
  const auto without = run_hector_slam(w.recording);
  for (MargSample& s : w.unit) s.angular_rate_radps.setConstant(MargSample::kNone);
  const auto with = run_hector_slam(w.recording, w.unit);
  ASSERT_TRUE(with && without);
  EXPECT_EQ(with->statistics.levelled_scans, 0U);
  for (std::size_t i = 0; i < with->trajectory.size(); ++i)
    ASSERT_EQ(with->trajectory[i].T_map_base.raw().translation(),
              without->trajectory[i].T_map_base.raw().translation());
}

}  // namespace
}  // namespace wayfare
