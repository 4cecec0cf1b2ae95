// Submap SLAM where tracking is lost: a robot that is carried, holes, a symmetric building.

#include <algorithm>
#include <cstddef>
#include <utility>

#include <gtest/gtest.h>

#include <wayfare/slam/submap_slam.hpp>
#include <wayfare/sync/odometry_track.hpp>

#include "carried.hpp"
#include "support.hpp"

namespace wayfare {
namespace {

class SubmapSlamOverTheFlat : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    run_ = new sim::SimulatedRun(simulate(kFlat, slipping_robot(), 1));
  }
  static void TearDownTestSuite() { delete run_; }

  static inline const sim::SimulatedRun* run_ = nullptr;
};

TEST_F(SubmapSlamOverTheFlat, IsOnePieceWhereNothingIsLost) {
  const auto slam = run_submap_slam(run_->recording);
  ASSERT_TRUE(slam) << slam.error().to_string();
  EXPECT_EQ(slam->statistics.pieces, 1U);
  EXPECT_EQ(slam->statistics.odometry_leaps, 0U);
  EXPECT_GT(slam->crossings.share, 0.0);  // it was looked for: some rays graze walls
  EXPECT_LT(slam->crossings.share, 0.01);
  EXPECT_LT(slam->crossings.worst_stretch, 0.05);
}

// The second half begins where the first ended or elsewhere; both see the whole flat.
TEST_F(SubmapSlamOverTheFlat, IsOneMapThoughTheRobotWasCarried) {
  for (const bool has_odometry : {true, false}) {
    sim::SimulatedRun run = carried(*run_, {{0.5, 1.0}, {0.0, 0.5}});
    if (!has_odometry) run.recording.odometry.clear();
    const auto slam = run_submap_slam(run.recording);
    ASSERT_TRUE(slam) << slam.error().to_string();
    EXPECT_EQ(slam->statistics.pieces_apart, 0U) << has_odometry;
    EXPECT_LT(rmse_m(slam->trajectory, run.truth), 0.15) << has_odometry;
  }
}

TEST_F(SubmapSlamOverTheFlat, IsJoinedAgainAfterAHoleWithoutOdometry) {
  sim::SimulatedRun run = with_hole(*run_, 40.0, 5.0);
  run.recording.odometry.clear();
  const auto slam = run_submap_slam(run.recording);
  ASSERT_TRUE(slam) << slam.error().to_string();
  EXPECT_GE(slam->statistics.pieces, 2U);
  EXPECT_EQ(slam->statistics.pieces_apart, 0U);
  EXPECT_LT(rmse_m(slam->trajectory, run.truth), 0.15);
}

// Something close around the scanner for three scans, fewer than `lost_scans`: odometry bridges
// them, whether or not a gyroscope measures its turns as well.
TEST_F(SubmapSlamOverTheFlat, AFewScansWithoutAMatchLoseNoRobotWithOdometry) {
  const Recording& recording = run_->recording;
  const OdometryTrack odometry(recording.odometry);
  for (const bool has_gyro : {false, true}) {
    SubmapSlamOptions options;
    options.T_base_laser = recording.T_base_laser;
    SubmapSlam slam(options);
    MotionHint hint;
    for (std::size_t i = 0; i < recording.scans.size() / 2; ++i) {
      LaserScan scan = recording.scans[i];
      if (i >= 100 && i < 103) std::fill(scan.ranges_m.begin(), scan.ranges_m.end(), 0.5F);
      const auto before = std::exchange(hint.odometry, odometry.at(scan.time));
      if (has_gyro && before)
        hint.turn = (hint.odometry->raw().heading() - before->raw().heading()).wrapped();
      ASSERT_TRUE(slam.add_scan(scan, hint));
    }
    EXPECT_EQ(slam.statistics().unmatched_scans, 3U) << has_gyro;
    EXPECT_EQ(slam.statistics().pieces, 1U) << has_gyro;
  }
}

// A robot that is set down in a place not seen before: its piece lies beside the map, and the map
// of the latest part is of that piece alone.
TEST_F(SubmapSlamOverTheFlat, ShowsThePiecesApart) {
  const sim::SimulatedRun run = carried(*run_, {{0.0, 0.08}, {0.22, 0.34}});
  const auto slam = run_submap_slam(run.recording);
  ASSERT_TRUE(slam) << slam.error().to_string();
  EXPECT_EQ(slam->statistics.pieces, 2U);
  EXPECT_EQ(slam->statistics.pieces_apart, 1U);
  SubmapSlamOptions options;
  options.T_base_laser = run.recording.T_base_laser;
  SubmapSlam live(options);
  const OdometryTrack odometry(run.recording.odometry);
  for (const LaserScan& scan : run.recording.scans)
    ASSERT_TRUE(live.add_scan(scan, {odometry.at(scan.time), {}}));
  const Trajectory latest = live.latest_trajectory(), all = live.trajectory();
  ASSERT_LT(latest.size(), all.size());
  EXPECT_EQ(latest.back().time, all.back().time);
  EXPECT_GT(latest.front().time, all.front().time);
  const auto part = live.latest_part().bounds(), whole = live.map().bounds();
  ASSERT_TRUE(part && whole);
  EXPECT_LT(part->max.x - part->min.x, (whole->max.x - whole->min.x) / 2);
}

// Any place fits as well as the one opposite: nothing tells which is right, so nothing is joined.
TEST(SubmapSlamPieces, OfASymmetricBuildingStayApart) {
  const sim::SimulatedRun run =
      carried(simulate(kSymmetric, slipping_robot(), 2), {{0.0, 0.55}, {0.68, 1.0}});
  const auto slam = run_submap_slam(run.recording);
  ASSERT_TRUE(slam) << slam.error().to_string();
  EXPECT_EQ(slam->statistics.joins, 0U);
  EXPECT_EQ(slam->statistics.pieces_apart, 1U);
}

TEST_F(SubmapSlamOverTheFlat, IsContinuedFromAStateWithPiecesAsIfWithoutInterruption) {
  const sim::SimulatedRun run = carried(*run_, {{0.5, 1.0}, {0.0, 0.5}});
  const Recording& recording = run.recording;
  SubmapSlamOptions options;
  options.T_base_laser = recording.T_base_laser;
  const OdometryTrack odometry(recording.odometry);
  SubmapSlam whole(options), part(options);
  std::size_t restored_apart = 0;
  for (std::size_t i = 0; i < recording.scans.size(); ++i) {
    const LaserScan& scan = recording.scans[i];
    const MotionHint hint{odometry.at(scan.time), {}};
    ASSERT_TRUE(whole.add_scan(scan, hint));
    ASSERT_TRUE(part.add_scan(scan, hint));
    const bool apart = part.statistics().pieces > 1 + part.statistics().joins;
    if (i % 100 != 0 && !(apart && i % 9 == 0)) continue;
    restored_apart += apart ? 1 : 0;
    auto restored = SubmapSlam::restore(part.save(), options);
    ASSERT_TRUE(restored) << restored.error().to_string();
    part = *std::move(restored);
  }
  EXPECT_GT(restored_apart, 2U);
  EXPECT_EQ(part.save(), whole.save());
}

// Old submaps are dropped, pieces with them.
TEST_F(SubmapSlamOverTheFlat, ForgetsPieces) {
  const sim::SimulatedRun run = carried(*run_, {{0.0, 0.08}, {0.22, 0.5}, {0.5, 1.0}});
  SubmapSlamOptions options;
  options.submap_nodes = 10;
  options.max_submaps = 3;
  const auto slam = run_submap_slam(run.recording, options);
  ASSERT_TRUE(slam) << slam.error().to_string();
  EXPECT_GT(slam->statistics.forgotten_submaps, 3U);
  EXPECT_GE(slam->statistics.pieces, 2U);
  EXPECT_EQ(slam->trajectory.size(), run.recording.scans.size());
}

}  // namespace
}  // namespace wayfare
