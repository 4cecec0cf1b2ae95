// Consistency of the covariances of the latest pose: normalised squared errors (NEES) against the
// truth, of the pose relative to the first.

#include <algorithm>
#include <cstdint>
#include <optional>
#include <string>

#include <gtest/gtest.h>

#include <wayfare/eval/pose_consistency.hpp>
#include <wayfare/slam/hector_slam.hpp>
#include <wayfare/slam/submap_slam.hpp>
#include <wayfare/sync/odometry_track.hpp>

#include "support.hpp"

namespace wayfare {
namespace {

using Odometer = std::optional<Transform2<frame::Odom, frame::Base>>;

MotionHint hint(const Odometer& odometry, const SubmapSlam&) { return {odometry, {}}; }
Odometer hint(const Odometer& odometry, const HectorSlam&) { return odometry; }

/// Every fifth pose of a drive.
template <class Slam, class Options>
double mean_nees(const sim::SimulatedRun& run, Options options) {
  options.T_base_laser = run.recording.T_base_laser;
  Slam slam(options);
  const OdometryTrack odometry(run.recording.odometry);
  eval::PoseConsistency consistency(run.truth);
  for (std::size_t i = 0; i < run.recording.scans.size(); ++i) {
    const LaserScan& scan = run.recording.scans[i];
    const auto outcome = slam.add_scan(scan, hint(odometry.at(scan.time), slam));
    EXPECT_TRUE(outcome);
    if (outcome && i % 5 == 0)
      consistency.add(scan.time, outcome->T_map_base.raw(), slam.covariance());
  }
  return consistency.mean_nees();
}

// Errors within a drive hang together: in the worst case a drive is one sample. So a consistent
// estimator's mean over five drives is within the bounds of five samples, and it is not to be more
// than three times too cautious in sigma.
TEST(SlamCovariance, AgreesWithTheErrorsAgainstTheTruth) {
  constexpr std::uint64_t kDrives = 5;
  SubmapSlamOptions small;
  small.submap_nodes = 20;  // closes loops of this length
  for (const auto& plan : {std::string(kRing), kOffice}) {
    eval::IndependentMean submaps, one_map;
    for (std::uint64_t seed = 1; seed <= kDrives; ++seed) {
      const auto run = simulate(plan, slipping_robot(), seed);
      submaps.add(mean_nees<SubmapSlam>(run, small));
      one_map.add(mean_nees<HectorSlam>(run, HectorSlamOptions()));
    }
    for (const double nees : {submaps.mean(), one_map.mean()}) {
      EXPECT_LT(nees, eval::mean_nees_bounds(3, kDrives, 0.999).high);
      EXPECT_GT(nees, 3.0 / 9.0);
    }
  }
}

// Without agreement the covariance is that of the last match and the motion since.
TEST(SlamCovariance, GrowsByTheMotionUntilScansMatchAgain) {
  const auto run = simulate(kOffice, slipping_robot(), 1);
  SubmapSlamOptions options;
  options.T_base_laser = run.recording.T_base_laser;
  options.lost_scans = 1000;
  SubmapSlam submaps(options);
  HectorSlamOptions of_one_map;
  of_one_map.T_base_laser = run.recording.T_base_laser;
  HectorSlam one_map(of_one_map);
  EXPECT_EQ(submaps.covariance(), Eigen::Matrix3d::Zero());
  EXPECT_EQ(one_map.covariance(), Eigen::Matrix3d::Zero());
  const OdometryTrack odometry(run.recording.odometry);
  double submaps_before = 0.0, one_map_before = 0.0;
  for (std::size_t i = 0; i < 40; ++i) {
    LaserScan scan = run.recording.scans[i];
    const bool is_blind = i >= 20 && i < 30;
    if (is_blind) std::ranges::fill(scan.ranges_m, 0.0F);
    ASSERT_TRUE(submaps.add_scan(scan, {odometry.at(scan.time), {}}));
    ASSERT_TRUE(one_map.add_scan(scan, odometry.at(scan.time)));
    const double of_submaps = submaps.covariance().trace(), of_one = one_map.covariance().trace();
    if (is_blind) {
      EXPECT_GT(of_submaps, submaps_before) << i;
      EXPECT_GT(of_one, one_map_before) << i;
    } else if (i == 30) {
      EXPECT_LT(of_submaps, submaps_before);
      EXPECT_LT(of_one, one_map_before);
    }
    submaps_before = of_submaps, one_map_before = of_one;
  }
}

}  // namespace
}  // namespace wayfare
