#include <wayfare/slam/graph_slam.hpp>

#include <cmath>
#include <cstddef>
#include <vector>

#include <gtest/gtest.h>

#include <wayfare/eval/trajectory_error.hpp>
#include <wayfare/sensors/trajectory.hpp>
#include <wayfare/slam/scan_outcome.hpp>
#include <wayfare/sync/odometry_track.hpp>

#include "support.hpp"

namespace wayfare {
namespace {

// The lidar's noise is 1-2 cm and the cells are 5 cm: a correctly closed loop is accurate to a few
// centimetres, a wrong one is off by half a metre and more.
TEST(GraphSlam, ClosesALoopOfCorridorsDespiteOdometryDrift) {
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    const auto run = simulate(kRing, slipping_robot(), seed);
    const auto slam = run_graph_slam(run.recording);
    ASSERT_TRUE(slam) << slam.error().to_string();
    EXPECT_EQ(slam->trajectory.size(), run.recording.scans.size());
    EXPECT_GT(slam->statistics.loop_closures, 5U);
    EXPECT_LT(rmse_m(slam->trajectory, run.truth), 0.10) << "seed " << seed;
    EXPECT_LT(rmse_m(slam->trajectory, run.truth),
              0.2 * rmse_m(as_trajectory(run.recording.odometry), run.truth));
  }
}

TEST(GraphSlam, ClosesTheLoopWithoutOdometry) {
  auto run = simulate(kRing, slipping_robot(), 4);
  run.recording.odometry.clear();
  const auto slam = run_graph_slam(run.recording);
  ASSERT_TRUE(slam) << slam.error().to_string();
  EXPECT_LT(rmse_m(slam->trajectory, run.truth), 0.15);
}

// Counters set to zero half way: the second piece is joined to the first at its true place, or kept
// apart from it; the leap itself never enters the map.
TEST(GraphSlam, BeginsAPieceWhereOdometryLeaps) {
  auto run = simulate(kRing, slipping_robot(), 1);
  auto& odometry = run.recording.odometry;
  const std::size_t half = odometry.size() / 2;
  const SE2d zero = odometry[half].T_odom_base.raw().inverse();
  ASSERT_GT(zero.translation().norm(), 2.0);
  for (std::size_t i = half; i < odometry.size(); ++i)
    odometry[i].T_odom_base =
        Transform2<frame::Odom, frame::Base>(zero * odometry[i].T_odom_base.raw());
  const auto slam = run_graph_slam(run.recording);
  ASSERT_TRUE(slam) << slam.error().to_string();
  EXPECT_GE(slam->statistics.odometry_leaps, 1U);
  EXPECT_GE(slam->statistics.pieces, 2U);
  EXPECT_TRUE(slam->statistics.pieces_apart > 0 || rmse_m(slam->trajectory, run.truth) < 0.15);
}

// Along featureless walls odometry must give the motion: matching tends to pull a robot back into
// the known part of the corridor. Slip of 5 mm/√m makes 3.5 cm over 50 m; the margin is for the
// ends of the corridor, which do come into view.
TEST(GraphSlam, KeepsTheLengthOfAFeaturelessCorridor) {
  sim::RobotParams robot = slipping_robot();
  robot.wheels.right_scale = 1.0;
  robot.lidar.max_range_m = 8.0;
  const auto run = simulate(kCorridor, robot, 5);
  const auto slam = run_graph_slam(run.recording);
  ASSERT_TRUE(slam) << slam.error().to_string();
  const auto length = [](const Trajectory& t) {
    return (t.back().T_map_base.raw().translation() - t.front().T_map_base.raw().translation())
        .norm();
  };
  EXPECT_NEAR(length(slam->trajectory), length(run.truth), 0.02 * length(run.truth));
  // An edge in the featureless part is less certain along the corridor than across it.
  const auto& edge = slam->graph.edges[slam->graph.edges.size() / 2];
  EXPECT_GT(edge.information(1, 1), 2.0 * edge.information(0, 0));
}

// A scan without returns is placed by odometry alone, here without motion: exactly at the pose of
// the last one after the last optimisation.
TEST(GraphSlam, ContinuesFromTheOptimisedPose) {
  const auto run = simulate(kRing, slipping_robot(), 1);
  const OdometryTrack odometry(run.recording.odometry);
  GraphSlamOptions options;
  options.T_base_laser = run.recording.T_base_laser;
  GraphSlam slam(options);
  for (const LaserScan& scan : run.recording.scans)
    ASSERT_TRUE(slam.add_scan(scan, odometry.at(scan.time)));
  const SE2d before = slam.trajectory().back().T_map_base.raw();
  ASSERT_TRUE(slam.finish());
  const SE2d last = slam.trajectory().back().T_map_base.raw();
  ASSERT_GT(last.minus(before).norm(), 1e-9);
  LaserScan blind = run.recording.scans.back();
  for (float& r : blind.ranges_m) r = 0.0F;
  const auto outcome = slam.add_scan(blind, odometry.at(blind.time));
  ASSERT_TRUE(outcome);
  EXPECT_LT(outcome->T_map_base.raw().minus(last).norm(), 1e-12);
}

/// The scan at which loop closure moves the graph most, seen at the previous node.
struct Jump {
  std::size_t scan = 0;
  double size_m = 0.0;
};

Jump largest_jump(const Recording& recording, const GraphSlamOptions& options) {
  GraphSlam slam(options);
  Jump largest;
  for (std::size_t i = 0; i < recording.scans.size(); ++i) {
    const std::vector<SE2d> before = slam.graph().poses;
    const auto outcome = slam.add_scan(recording.scans[i], std::nullopt);
    if (!outcome || outcome->loop_closures == 0) continue;
    const double moved =
        (slam.graph().poses[before.size() - 1].translation() - before.back().translation()).norm();
    if (moved > largest.size_m) largest = {i, moved};
  }
  return largest;
}

// Without odometry a scan without returns is placed at constant velocity: that between the last two
// scans, which matching measures to 2 cm, however far the graph has moved since.
TEST(GraphSlam, GraphCorrectionsDoNotChangeTheVelocity) {
  auto run = simulate(kRing, slipping_robot(), 10);
  Recording& recording = run.recording;
  GraphSlamOptions options;
  options.T_base_laser = recording.T_base_laser;
  options.max_range_m = 6.0;  // drifts along the corridors
  const Jump jump = largest_jump(recording, options);
  ASSERT_GT(jump.size_m, 0.3);
  GraphSlam slam(options);
  SE2d last;
  for (std::size_t i = 0; i <= jump.scan; ++i)
    last = slam.add_scan(recording.scans[i], std::nullopt)->T_map_base.raw();
  LaserScan blind = recording.scans[jump.scan];
  blind.time += blind.time - recording.scans[jump.scan - 1].time;
  for (float& r : blind.ranges_m) r = 0.0F;
  const SE2d blind_step = last.inverse() * slam.add_scan(blind, std::nullopt)->T_map_base.raw();
  const auto truth = [&](std::size_t i) { return *pose_at(run.truth, recording.scans[i].time); };
  const SE2d true_step = truth(jump.scan - 1).inverse() * truth(jump.scan);
  EXPECT_LT((blind_step.translation() - true_step.translation()).norm(), 0.03);
}

TEST(GraphSlam, GivesTheSameBytesForAnyNumberOfThreads) {
  const auto run = simulate(kRing, slipping_robot(), 6);
  GraphSlamOptions two;
  two.threads = 2;
  const auto a = run_graph_slam(run.recording), b = run_graph_slam(run.recording, two);
  ASSERT_TRUE(a && b);
  ASSERT_EQ(a->graph.edges.size(), b->graph.edges.size());
  ASSERT_EQ(a->trajectory.size(), b->trajectory.size());
  for (std::size_t i = 0; i < a->trajectory.size(); ++i) {
    const SE2d p = a->trajectory[i].T_map_base.raw(), q = b->trajectory[i].T_map_base.raw();
    ASSERT_EQ(p.translation(), q.translation()) << "scan " << i;
    ASSERT_EQ(p.rotation().cos(), q.rotation().cos()) << "scan " << i;
  }
}

TEST(GraphSlam, MapsTheWallsAtTheirTruePositions) {
  GraphSlam slam;
  for (int k = 0; k < 20; ++k) {
    const double x = 2.0 + 0.1 * k;
    ASSERT_TRUE(slam.add_scan(room_scan(0.2 * k, x, 1.5),
                              Transform2<frame::Odom, frame::Base>(SE2d(x, 1.5, Angle{}))));
  }
  ASSERT_TRUE(slam.finish());
  const OccupancyGrid map = slam.map();
  const auto occupied_near = [&](double x, double y) {
    for (int dx = -1; dx <= 1; ++dx)
      for (int dy = -1; dy <= 1; ++dy)
        if (map.probability(cell_of({x + 0.05 * dx, y + 0.05 * dy}, map.resolution_m())) > 0.6)
          return true;
    return false;
  };
  EXPECT_TRUE(occupied_near(6.0, 2.0));
  EXPECT_TRUE(occupied_near(0.0, 1.0));
  EXPECT_TRUE(occupied_near(3.0, 4.0));
  EXPECT_TRUE(occupied_near(3.0, 0.0));
  EXPECT_LT(map.probability(cell_of({3.0, 2.0}, map.resolution_m())), 0.3);
}

}  // namespace
}  // namespace wayfare
