// Accuracy of submap SLAM, and independence of its results.

#include <wayfare/slam/submap_slam.hpp>

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include <wayfare/eval/trajectory_error.hpp>
#include <wayfare/sync/odometry_track.hpp>

#include "io/support.hpp"
#include "log_relations.hpp"
#include "support.hpp"

namespace wayfare {
namespace {

/// Small submaps, so that the loop has finished ones.
SubmapSlamOptions small_submaps() {
  SubmapSlamOptions options;
  options.submap_nodes = 20;
  return options;
}

Result<void> feed(SubmapSlam& slam, const Recording& recording, std::size_t from, std::size_t to) {
  const OdometryTrack odometry(recording.odometry);
  for (std::size_t i = from; i < to; ++i) {
    const LaserScan& scan = recording.scans[i];
    if (auto ok = slam.add_scan(scan, {odometry.at(scan.time), {}}); !ok) return ok.error();
  }
  return {};
}

// The lidar's noise is 1-2 cm and the cells are 5 cm: a correctly closed loop is accurate to a few
// centimetres, a wrong one is off by half a metre and more.
TEST(SubmapSlam, ClosesALoopOfCorridorsDespiteOdometryDrift) {
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    const auto run = simulate(kRing, slipping_robot(), seed);
    const auto slam = run_submap_slam(run.recording, small_submaps());
    ASSERT_TRUE(slam) << slam.error().to_string();
    EXPECT_EQ(slam->trajectory.size(), run.recording.scans.size());
    EXPECT_GT(slam->statistics.loop_closures, 5U);
    EXPECT_LT(rmse_m(slam->trajectory, run.truth), 0.10) << "seed " << seed;
  }
}

TEST(SubmapSlam, ClosesTheLoopByScansAlone) {
  auto run = simulate(kRing, slipping_robot(), 4);
  run.recording.odometry.clear();
  const auto slam = run_submap_slam(run.recording, small_submaps());
  ASSERT_TRUE(slam) << slam.error().to_string();
  EXPECT_LT(rmse_m(slam->trajectory, run.truth), 0.15);
}

// Slip of 5 mm/√m makes 3.5 cm over 50 m; the margin is for the corridor's ends.
TEST(SubmapSlam, KeepsTheLengthOfAFeaturelessCorridor) {
  sim::RobotParams robot = slipping_robot();
  robot.wheels.right_scale = 1.0;
  robot.lidar.max_range_m = 8.0;
  const auto run = simulate(kCorridor, robot, 5);
  const auto slam = run_submap_slam(run.recording);
  ASSERT_TRUE(slam) << slam.error().to_string();
  const auto length = [](const Trajectory& t) {
    return (t.back().T_map_base.raw().translation() - t.front().T_map_base.raw().translation())
        .norm();
  };
  EXPECT_NEAR(length(slam->trajectory), length(run.truth), 0.02 * length(run.truth));
}

TEST(SubmapSlam, SameBytesForAnyNumberOfThreads) {
  const auto run = simulate(kRing, slipping_robot(), 1);
  std::vector<std::uint8_t> one;
  for (const int threads : {1, 2, 3, 0}) {
    SubmapSlamOptions options = small_submaps();
    options.threads = threads;
    options.T_base_laser = run.recording.T_base_laser;
    SubmapSlam slam(options);
    ASSERT_TRUE(feed(slam, run.recording, 0, run.recording.scans.size()));
    ASSERT_TRUE(slam.finish());
    EXPECT_GT(slam.statistics().loop_closures, 0U);
    const auto bytes = slam.save();
    if (one.empty()) one = bytes;
    ASSERT_EQ(bytes, one) << threads << " threads";
  }
}

// Tables are dropped and made again, more than are kept in a single search: only the time differs.
TEST(SubmapSlam, SameBytesForAnyNumberOfTables) {
  const auto run = simulate(kRing, slipping_robot(), 2);
  std::vector<std::uint8_t> few;
  for (const int tables : {1, 2, 5, 100}) {
    SubmapSlamOptions options = small_submaps();
    options.tables_kept = tables;
    options.threads = tables == 2 ? 3 : 1;
    options.T_base_laser = run.recording.T_base_laser;
    SubmapSlam slam(options);
    ASSERT_TRUE(feed(slam, run.recording, 0, run.recording.scans.size()));
    ASSERT_TRUE(slam.finish());
    const auto bytes = slam.save();
    if (few.empty()) few = bytes;
    ASSERT_EQ(bytes, few) << tables << " tables";
  }
}

// A field of too many cells is an error of each search, which says so.
TEST(SubmapSlam, SearchesInCellsOfAnySize) {
  const auto run = simulate(kRing, slipping_robot(), 1);
  for (const double cell_m : {0.05, 0.075, 0.15, 1e-6}) {
    SubmapSlamOptions options = small_submaps();
    options.loop_cell_m = cell_m;
    const auto slam = run_submap_slam(run.recording, options);
    ASSERT_TRUE(slam) << slam.error().to_string();
    const SubmapSlamStatistics& s = slam->statistics;
    EXPECT_EQ(s.loop_closures > 5U, cell_m > 1e-3) << cell_m;
    EXPECT_EQ(s.matcher_errors.count, cell_m > 1e-3 ? 0U : s.loops_refused) << cell_m;
    EXPECT_EQ(s.matcher_errors.first.find("loop") != std::string::npos, cell_m < 1e-3)
        << s.matcher_errors.first;
  }
}

// A running search is waited for before its data is destroyed.
TEST(SubmapSlam, MayBeDestroyedDuringASearch) {
  const auto run = simulate(kRing, slipping_robot(), 1);
  SubmapSlamOptions options = small_submaps();
  options.threads = 2;
  options.loop_latency_scans = 1000000;
  options.T_base_laser = run.recording.T_base_laser;
  SubmapSlam slam(options);
  ASSERT_TRUE(feed(slam, run.recording, 0, run.recording.scans.size()));
  EXPECT_EQ(slam.statistics().loop_closures, 0U);
}

// Wherever the interruption is: between searches and during one.
TEST(SubmapSlam, ContinuesFromASavedState) {
  const auto run = simulate(kRing, slipping_robot(), 2);
  SubmapSlamOptions options = small_submaps();
  options.T_base_laser = run.recording.T_base_laser;
  const std::size_t n = run.recording.scans.size();
  SubmapSlam whole(options);
  ASSERT_TRUE(feed(whole, run.recording, 0, n));
  ASSERT_TRUE(whole.finish());
  for (const std::size_t at : {n / 3, n / 2 + 1, n / 2 + 4, n - 1}) {
    SubmapSlam first(options);
    ASSERT_TRUE(feed(first, run.recording, 0, at));
    const auto saved = first.save();
    auto second = SubmapSlam::restore(saved, options);
    ASSERT_TRUE(second) << second.error().to_string();
    EXPECT_EQ(second->save(), saved);
    ASSERT_TRUE(feed(*second, run.recording, at, n));
    ASSERT_TRUE(second->finish());
    ASSERT_EQ(second->save(), whole.save()) << "after scan " << at;
  }
}

// Two rounds of the loop: the poses remain, the map is that of the newest submaps.
TEST(SubmapSlam, ForgetsOldSubmapsAndContinues) {
  const auto run = simulate(kRing, slipping_robot(), 3);
  SubmapSlamOptions options = small_submaps();
  options.tables_kept = 2;
  const auto all = run_submap_slam(run.recording, options);
  options.max_submaps = 4;
  const auto some = run_submap_slam(run.recording, options);
  ASSERT_TRUE(all && some);
  EXPECT_GT(some->statistics.forgotten_submaps, 3U);
  EXPECT_EQ(some->trajectory.size(), run.recording.scans.size());
  EXPECT_LE(some->graph.size(), 6 * (options.submap_nodes + 1));
  EXPECT_LT(some->memory_bytes, all->memory_bytes);
  EXPECT_LT(rmse_m(some->trajectory, run.truth), 0.5);
}

// As a node that runs for days: the trajectory, too, is the latest alone.
TEST(SubmapSlam, ForgetsOldPosesToo) {
  const auto run = simulate(kRing, slipping_robot(), 3);
  SubmapSlamOptions options = small_submaps();
  options.max_submaps = 4;
  const auto all = run_submap_slam(run.recording, options);
  options.max_forgotten_poses = 7;
  const auto some = run_submap_slam(run.recording, options);
  ASSERT_TRUE(all && some);
  EXPECT_LT(some->trajectory.size(), all->trajectory.size());
  const auto kept =
      std::ranges::find(all->trajectory, some->trajectory.front().time, &StampedPose::time);
  ASSERT_TRUE(std::equal(some->trajectory.begin(), some->trajectory.end(), kept,
                         all->trajectory.end(), [](const auto& a, const auto& b) {
                           return a.time == b.time &&
                                  a.T_map_base.raw().minus(b.T_map_base.raw()).norm() == 0.0;
                         }));
  EXPECT_LT(some->memory_bytes, all->memory_bytes);
}

struct Reached {
  eval::RelationsResult between, nearest;
};

Reached relations_of(const std::string& log_path, const std::string& relations_path,
                     bool with_odometry) {
  const auto log = testing::read_log_with_relations(log_path, relations_path, with_odometry);
  if (!log) return {};
  const auto run = run_submap_slam(log->recording);
  if (!run) return {};
  return {eval::relations_error(run->trajectory, log->relations),
          eval::relations_error(run->trajectory, log->relations, {.nearest_pose = true})};
}

// Published for Cartographer: 0.0452 m, 0.538 deg. The file's timestamps jitter by tens of
// milliseconds, so only the nearest scans' headings are compared.
TEST(SubmapSlamRealLogs, Freiburg079WithAndWithoutOdometry) {
  WAYFARE_NEEDS_RECORDING(log, "slam2d/fr079.clf.gz");
  WAYFARE_NEEDS_RECORDING(relations, "slam2d/fr079.relations.gz");
  for (const bool with_odometry : {true, false}) {
    const Reached e = relations_of(log, relations, with_odometry);
    EXPECT_GE(e.between.used, WAYFARE_TEST_SCANS == 0 ? 1685U : 100U);
    EXPECT_LT(e.between.translation_m.mean, 0.0452);
    EXPECT_LT(e.between.rotation_deg.mean, 0.80);
    EXPECT_LT(e.nearest.translation_m.mean, 0.0452);
    EXPECT_LT(e.nearest.rotation_deg.mean, 0.538);
  }
}

TEST(SubmapSlamRealLogs, Intel) {
  WAYFARE_NEEDS_RECORDING(log, "slam2d/intel.clf.gz");
  WAYFARE_NEEDS_RECORDING(relations, "slam2d/intel.relations.gz");
  const Reached e = relations_of(log, relations, true);
  EXPECT_GE(e.between.used, WAYFARE_TEST_SCANS == 0 ? 2945U : 100U);
  EXPECT_LT(e.between.translation_m.mean, 0.090);
  EXPECT_LT(e.between.rotation_deg.mean, 2.5);
}

}  // namespace
}  // namespace wayfare
