// Graph SLAM where tracking is lost: holes, odometry set back, a robot that is carried, a building
// that looks the same from two sides.

#include <algorithm>
#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include <wayfare/sensors/trajectory.hpp>
#include <wayfare/slam/detail/graph_slam/loss_detector.hpp>
#include <wayfare/slam/detail/graph_slam/node_map.hpp>
#include <wayfare/slam/detail/graph_slam/piece_joiner.hpp>
#include <wayfare/slam/detail/graph_slam/wall_crossings.hpp>
#include <wayfare/slam/graph_slam.hpp>
#include <wayfare/sync/odometry_track.hpp>

#include "carried.hpp"
#include "support.hpp"

namespace wayfare {
namespace {

GraphSlamOptions options_of(const Recording& recording) {
  GraphSlamOptions options;
  options.T_base_laser = recording.T_base_laser;
  return options;
}

class GraphSlamOverTheFlat : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    run_ = new sim::SimulatedRun(simulate(kFlat, slipping_robot(), 1));
  }
  static void TearDownTestSuite() { delete run_; }

  static inline const sim::SimulatedRun* run_ = nullptr;
};

TEST_F(GraphSlamOverTheFlat, IsOnePieceWhereNothingIsLost) {
  const auto slam = run_graph_slam(run_->recording);
  ASSERT_TRUE(slam) << slam.error().to_string();
  EXPECT_EQ(slam->statistics.pieces, 1U);
  EXPECT_EQ(slam->statistics.pieces_apart, 0U);
  EXPECT_GT(slam->crossings.share, 0.0);  // it was looked for: some rays graze walls
  EXPECT_LT(slam->crossings.share, 0.01);
  EXPECT_LT(slam->crossings.worst_stretch, 0.05);
  EXPECT_LT(rmse_m(slam->trajectory, run_->truth), 0.10);
}

TEST_F(GraphSlamOverTheFlat, IsJoinedAgainAfterAHoleWithoutOdometry) {
  sim::SimulatedRun run = with_hole(*run_, 40.0, 5.0);
  run.recording.odometry.clear();
  const auto slam = run_graph_slam(run.recording);
  ASSERT_TRUE(slam) << slam.error().to_string();
  EXPECT_EQ(slam->statistics.pieces, 2U);
  EXPECT_EQ(slam->statistics.joins, 1U);
  EXPECT_LT(rmse_m(slam->trajectory, run.truth), 0.15);
}

// The second half begins where the first ended or elsewhere; both see the whole flat.
TEST_F(GraphSlamOverTheFlat, IsOneMapThoughTheRobotWasCarried) {
  for (const bool has_odometry : {true, false}) {
    sim::SimulatedRun run = carried(*run_, {{0.5, 1.0}, {0.0, 0.5}});
    if (!has_odometry) run.recording.odometry.clear();
    const auto slam = run_graph_slam(run.recording);
    ASSERT_TRUE(slam) << slam.error().to_string();
    EXPECT_GE(slam->statistics.pieces, 2U);
    EXPECT_EQ(slam->statistics.pieces_apart, 0U);
    EXPECT_LT(rmse_m(slam->trajectory, run.truth), 0.15) << has_odometry;
  }
}

// Odometry says that the robot stood while it was carried from one end to the other.
TEST_F(GraphSlamOverTheFlat, NoticesThatTheRobotWasLifted) {
  const sim::SimulatedRun run = carried(*run_, {{0.0, 0.45}, {0.6, 1.0}}, true);
  const auto slam = run_graph_slam(run.recording);
  ASSERT_TRUE(slam) << slam.error().to_string();
  EXPECT_GE(slam->statistics.pieces, 2U);
  EXPECT_TRUE(slam->statistics.pieces_apart > 0 || rmse_m(slam->trajectory, run.truth) < 0.15);
}

TEST_F(GraphSlamOverTheFlat, IsContinuedFromAStateWithPiecesAsIfWithoutInterruption) {
  const sim::SimulatedRun run = carried(*run_, {{0.5, 1.0}, {0.0, 0.5}});
  const Recording& recording = run.recording;
  const OdometryTrack odometry(recording.odometry);
  GraphSlam whole(options_of(recording)), part(options_of(recording));
  std::size_t restored_apart = 0;
  for (std::size_t i = 0; i < recording.scans.size(); ++i) {
    const LaserScan& scan = recording.scans[i];
    ASSERT_TRUE(whole.add_scan(scan, odometry.at(scan.time)));
    ASSERT_TRUE(part.add_scan(scan, odometry.at(scan.time)));
    const bool apart = part.statistics().pieces > 1 + part.statistics().joins;
    if (i % 100 != 0 && !(apart && i % 5 == 0)) continue;
    restored_apart += apart ? 1 : 0;
    auto restored = GraphSlam::restore(part.save(), options_of(recording));
    ASSERT_TRUE(restored) << restored.error().to_string();
    part = *std::move(restored);
  }
  EXPECT_GT(restored_apart, 3U);
  EXPECT_EQ(part.save(), whole.save());
  ASSERT_TRUE(part.finish() && whole.finish());
  EXPECT_EQ(part.save(), whole.save());
}

// Any place fits as well as the one opposite: nothing tells which is right, so nothing is joined.
TEST(GraphSlamPieces, OfASymmetricBuildingStayApart) {
  for (const bool has_odometry : {true, false}) {
    sim::SimulatedRun run =
        carried(simulate(kSymmetric, slipping_robot(), 2), {{0.0, 0.55}, {0.68, 1.0}});
    if (!has_odometry) run.recording.odometry.clear();
    const auto slam = run_graph_slam(run.recording);
    ASSERT_TRUE(slam) << slam.error().to_string();
    EXPECT_EQ(slam->statistics.pieces_apart, 1U) << has_odometry;
    EXPECT_EQ(slam->statistics.joins, 0U);
  }
}

PointSet points_at(std::initializer_list<Eigen::Vector2f> xy) {
  PointSet points;
  for (const Eigen::Vector2f& p : xy) points.push_back(p);
  return points;
}

TEST(NodeMap, JoinsPartsByMovingTheLater) {
  detail::NodeMap nodes;
  const PointSet points = points_at({{1.0F, 0.0F}});
  const Eigen::Matrix3d information = Eigen::Matrix3d::Identity();
  nodes.start(SE2d(), points);
  nodes.append(SE2d(1.0, 0.0, Angle()), points, information);
  nodes.start(SE2d(60.0, 0.0, Angle()), points, SE2d(2.0, 0.0, Angle()), 3.0);
  nodes.append(SE2d(61.0, 0.0, Angle()), points, information);
  EXPECT_EQ(nodes.parts(), (std::vector<int>{0, 1}));
  EXPECT_EQ(nodes.graph().fixed, (std::vector<int>{0, 2}));
  EXPECT_EQ(nodes.piece(1).before, 1);
  // Node 3 is 5 m to the left of node 1 and looks left: node 2 is 1 m behind it.
  nodes.join({{1, 3, SE2d(0.0, 5.0, Angle::degrees(90)), information, true}});
  EXPECT_EQ(nodes.parts(), std::vector<int>{0});
  EXPECT_TRUE(nodes.graph().fixed.empty());
  EXPECT_LT((nodes.pose(2).translation() - Eigen::Vector2d(1.0, 4.0)).norm(), 1e-12);
  EXPECT_NEAR(nodes.pose(2).heading().degrees(), 90.0, 1e-9);
  EXPECT_EQ(nodes.nodes_of_part(0).size(), 4U);
}

TEST(NodeMap, KeepsThePiecesInOrderWhenANodeIsErased) {
  detail::NodeMap nodes;
  const PointSet points = points_at({{1.0F, 0.0F}});
  const Eigen::Matrix3d information = Eigen::Matrix3d::Identity();
  nodes.start(SE2d(), points);
  nodes.append(SE2d(1.0, 0.0, Angle()), points, information);
  nodes.start(SE2d(60.0, 0.0, Angle()), points, SE2d(2.0, 0.0, Angle()), 3.0);
  nodes.possible_joins().push_back({0, 2, SE2d(), information, true});
  nodes.graph().edges.clear();
  nodes.erase(1);
  EXPECT_EQ(nodes.first_of_piece(1), 1);
  EXPECT_EQ(nodes.piece_of(0), 0);
  EXPECT_EQ(nodes.piece_of(1), 1);
  EXPECT_EQ(nodes.piece(1).reach_m, 0.0);  // what it was expected from is gone
  EXPECT_EQ(nodes.possible_joins().front().to, 1);
}

// A wall at x = 3: of two rays from the origin, that to 6 m crosses it, that to 3 m ends at it.
TEST(WallCrossings, CountRaysThatEndBehindWalls) {
  OccupancyGrid grid;
  const PointSet wall = points_at({{3.0F, -0.05F}, {3.0F, 0.0F}, {3.0F, 0.05F}});
  ScanRaster raster;
  for (int i = 0; i < 10; ++i)
    ASSERT_TRUE(insert_points(grid, SE2d(), wall, {}, raster, Eigen::Vector2d::Zero()));
  const PointSet seen = points_at({{6.0F, 0.0F}, {3.0F, 0.0F}});
  const std::vector<PlacedPoints> scans = {{&seen, SE2d()}};
  const WallCrossings crossings = detail::wall_crossings(scans, grid, Eigen::Vector2d::Zero());
  EXPECT_DOUBLE_EQ(crossings.share, 0.5);
  EXPECT_DOUBLE_EQ(crossings.worst_stretch, 0.5);
  EXPECT_EQ(detail::wall_crossings({}, grid, Eigen::Vector2d::Zero()).worst_stretch, 0.0);
}

// Scans of 0.2 s intervals: lost after the options' number without odometry, at once after a break.
TEST(LossDetector, IsLostAfterScansInARowOrABreak) {
  const GraphSlamOptions options;
  detail::LossDetector loss(options);
  Motion guessed;
  double t = 0.0;
  const auto next = [&](double step_s, bool found) {
    t += step_s;
    loss.expect(LogTime::from_seconds(t));
    const bool lost = loss.is_lost(found, guessed);
    loss.add(LogTime::from_seconds(t), found, guessed, SE2d());
    return lost;
  };
  loss.begin(LogTime::from_seconds(0.0));
  for (int i = 0; i < 20; ++i) EXPECT_FALSE(next(0.2, true));
  for (int i = 1; i < options.lost_scans_without_odometry; ++i) EXPECT_FALSE(next(0.2, false));
  EXPECT_TRUE(next(0.2, false));
  EXPECT_FALSE(next(0.2, true));
  EXPECT_TRUE(next(5.0, false));
  guessed.measured = true;
  EXPECT_FALSE(next(0.2, true));
  for (int i = 1; i < options.lost_scans; ++i) EXPECT_FALSE(next(0.2, false));
  EXPECT_TRUE(next(0.2, false));
}

// A break: more than four usual steps, and 2.5 s, or 5 s where a velocity does not hold from scan
// to scan and the search reaches as far as the robot drives. With steps above a second gaps are
// usual.
TEST(Gap, IsABreakByItsUsualStep) {
  const auto is_break = [](double usual_s, double silent_s) {
    detail::Gap gap;
    gap.add_interval(usual_s);
    gap.begin(silent_s, false);
    return gap.is_break();
  };
  EXPECT_FALSE(is_break(0.2, 2.4));
  EXPECT_TRUE(is_break(0.2, 2.6));
  EXPECT_FALSE(is_break(0.6, 4.9));
  EXPECT_TRUE(is_break(0.6, 5.1));
  EXPECT_FALSE(is_break(1.1, 60.0));
}

}  // namespace
}  // namespace wayfare
