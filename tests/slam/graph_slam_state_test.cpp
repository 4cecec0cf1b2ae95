// Saved states of graph SLAM, and merging of nodes in known area.

#include <algorithm>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include <wayfare/slam/detail/graph_slam/node_merger.hpp>
#include <wayfare/slam/detail/graph_slam/state.hpp>
#include <wayfare/slam/graph_slam.hpp>
#include <wayfare/sync/odometry_track.hpp>

#include "support.hpp"

namespace wayfare {
namespace {

/// More than two laps of the ring.
sim::SimulatedRun two_laps() {
  std::string plan(kRing);
  const std::string_view route = "a b c d a b";
  plan.replace(plan.find(route), route.size(), "a b c d a b c d a b");
  return simulate(plan, slipping_robot(), 6);
}

GraphSlamOptions merging() {
  GraphSlamOptions options;
  options.nodes_before_merging = 1;
  return options;
}

void feed(GraphSlam& slam, const Recording& recording, std::size_t from, std::size_t to) {
  const OdometryTrack odometry(recording.odometry);
  for (std::size_t i = from; i < to; ++i) {
    const LaserScan& scan = recording.scans[i];
    ASSERT_TRUE(slam.add_scan(scan, odometry.at(scan.time)));
  }
}

class GraphSlamOverTwoLaps : public ::testing::Test {
 protected:
  static void SetUpTestSuite() { run_ = new sim::SimulatedRun(two_laps()); }
  static void TearDownTestSuite() { delete run_; }
  [[nodiscard]] static const Recording& recording() { return run_->recording; }

  static inline const sim::SimulatedRun* run_ = nullptr;
};

TEST_F(GraphSlamOverTwoLaps, IsContinuedFromASavedStateAsIfWithoutInterruption) {
  const std::size_t n = recording().scans.size();
  GraphSlam whole(merging());
  feed(whole, recording(), 0, n);
  GraphSlam part(merging());
  std::size_t done = 0;
  for (const std::size_t until : {n / 3, n / 2, n - 20, n}) {
    feed(part, recording(), done, until);
    done = until;
    auto restored = GraphSlam::restore(part.save(), merging());
    ASSERT_TRUE(restored) << restored.error().to_string();
    part = *std::move(restored);
  }
  EXPECT_EQ(part.save(), whole.save());
  ASSERT_TRUE(part.finish());
  ASSERT_TRUE(whole.finish());
  EXPECT_EQ(part.save(), whole.save());
}

TEST_F(GraphSlamOverTwoLaps, MergesTheNodesOfKnownArea) {
  GraphSlam all, merged(merging());
  feed(all, recording(), 0, recording().scans.size());
  feed(merged, recording(), 0, recording().scans.size());
  ASSERT_TRUE(merged.finish());
  // The second lap and the start of the third are known, but for the window of the latest nodes.
  EXPECT_LT(merged.graph().size(), 0.8 * all.graph().size());
  EXPECT_EQ(merged.trajectory().size(), recording().scans.size());
  EXPECT_LT(rmse_m(merged.trajectory(), run_->truth), 0.10);  // as without merging
  for (const PoseEdge<SE2d>& e : merged.graph().edges) {
    EXPECT_TRUE(e.from != e.to && std::min(e.from, e.to) >= 0 &&
                std::max(e.from, e.to) < merged.graph().size());
    EXPECT_TRUE(e.information.allFinite());
  }
}

// Loops are then matched to the nodes nearest to a candidate, not to those numbered next.
TEST(GraphSlamState, AMapWithoutSomeOfItsNodesIsMerged) {
  detail::NodeMap nodes;
  nodes.start(SE2d(), PointSet());
  nodes.append(SE2d(1, 0, {}), PointSet(), Eigen::Matrix3d::Identity());
  EXPECT_FALSE(nodes.merged());
  nodes.graph().edges.clear();
  nodes.erase(1);
  EXPECT_TRUE(nodes.merged());
}

/// Of two laps around a square of 10 m, with a node every metre; the number of nodes
/// removed.
int removed_by_merging(double step_sigma_m) {
  GraphSlamOptions options = merging();
  options.local_nodes = options.sharp_nodes = options.loop_gap_nodes = 0;
  detail::NodeMap nodes;
  detail::NodeMerger merger(options);
  std::vector<ScanPose> scans;
  const Eigen::Matrix3d information =
      Eigen::Vector3d(step_sigma_m, step_sigma_m, 1e-3).cwiseAbs2().cwiseInverse().asDiagonal();
  SE2d pose;
  nodes.start(pose, PointSet());
  int removed = 0;
  for (int step = 1; step <= 80; ++step) {
    pose = pose * SE2d(1.0, 0.0, step % 10 == 0 ? Angle::degrees(90) : Angle());
    nodes.append(pose, PointSet(), information);
    removed += merger.update(nodes, scans);
  }
  return removed;
}

// The uncertainty of a lap is three standard deviations of 40 steps, about 1 m and 4 m.
TEST(GraphSlamState, NodesAreMergedWhereTheySurelyShareTheViewOfOlderOnes) {
  EXPECT_GT(removed_by_merging(0.05), 0);
  EXPECT_EQ(removed_by_merging(0.20), 0);
}

// Joining pieces removes no node: those numbered next are still those passed next.
TEST(GraphSlamState, AMapOfJoinedPiecesIsNotMerged) {
  detail::NodeMap nodes;
  nodes.start(SE2d(), PointSet());
  nodes.start(SE2d(50, 0, {}), PointSet());
  nodes.append(SE2d(51, 0, {}), PointSet(), Eigen::Matrix3d::Identity());
  nodes.join({{0, 1, SE2d(2, 0, {}), Eigen::Matrix3d::Identity(), true}});
  EXPECT_EQ(nodes.parts().size(), 1U);
  EXPECT_NEAR(nodes.pose(2).x(), 3.0, 1e-12);
  EXPECT_FALSE(nodes.merged());
}

TEST(GraphSlamState, RefusesWhatIsNotOne) {
  const std::vector<std::uint8_t> saved = GraphSlam().save();
  EXPECT_TRUE(GraphSlam::restore(saved));
  EXPECT_FALSE(GraphSlam::restore({}));
  EXPECT_FALSE(GraphSlam::restore(std::span(saved).first(saved.size() - 1)));
  for (std::size_t i = 0; i < saved.size(); i += 7) {
    std::vector<std::uint8_t> damaged = saved;
    damaged[i] ^= 4U;
    const auto restored = GraphSlam::restore(damaged);
    ASSERT_FALSE(restored) << "byte " << i;
    EXPECT_EQ(restored.error().source, "saved map");
  }
}

TEST(GraphSlamState, OfNoScansIsContinued) {
  auto restored = GraphSlam::restore(GraphSlam().save());
  ASSERT_TRUE(restored);
  EXPECT_TRUE(restored->add_scan(room_scan(1.0, 2.0, 2.0), {}));
  EXPECT_EQ(restored->statistics().scans, 1U);
}

}  // namespace
}  // namespace wayfare
