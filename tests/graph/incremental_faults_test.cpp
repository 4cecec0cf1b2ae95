// Invalid and pending additions to an incremental graph.

#include <limits>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <wayfare/graph/incremental.hpp>
#include <wayfare/graph/optimise.hpp>

#include "growth.hpp"

namespace wayfare {
namespace {

using ::testing::HasSubstr;
using tests::apart;
using tests::kExact;
using tests::random_walk;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

struct BadEdge {
  const char* message;
  PoseEdge<SE2d> edge;
};

TEST(IncrementalFaults, RejectsEdgesByNameAndIsUnaffectedByThem) {
  Rng rng(15);
  const auto whole = random_walk<SE2d>(rng, 10);
  IncrementalOptimiser<SE2d> growing;
  ASSERT_TRUE(growing.append(whole));
  ASSERT_TRUE(growing.update(kExact));
  const auto before = growing.poses();
  const std::size_t edges = growing.graph().edges.size();
  Eigen::Matrix3d indefinite = Eigen::Matrix3d::Identity();
  indefinite(1, 1) = -1.0;
  for (const auto& [message, edge] :
       {BadEdge{"names pose 10, which", {3, 10, SE2d()}}, BadEdge{"names pose -1", {-1, 3, SE2d()}},
        BadEdge{"(4 -> 4) joins a pose to itself", {4, 4, SE2d()}},
        BadEdge{"measurement that is not finite", {1, 2, SE2d(kNan, 0.0, 0.0_rad)}},
        BadEdge{"not positive semi-definite", {1, 2, SE2d(), indefinite}},
        BadEdge{"has zero information", {1, 2, SE2d(), Eigen::Matrix3d::Zero()}},
        BadEdge{"too large to square", {1, 2, SE2d(1e200, 0.0, 0.0_rad)}}}) {
    const auto added = growing.add_edge(edge);
    ASSERT_FALSE(added) << message;
    EXPECT_THAT(added.error().message, HasSubstr(message));
  }
  const auto pose = growing.add_pose(SE2d(0.0, kNan, 0.0_rad));
  ASSERT_FALSE(pose);
  EXPECT_EQ(pose.error().message, "pose 10 is not finite");
  EXPECT_EQ(growing.graph().edges.size(), edges);
  EXPECT_EQ(apart(growing.poses(), before), 0.0);
  EXPECT_TRUE(growing.update());
}

TEST(IncrementalFaults, ReportsAnEmptyGraph) {
  IncrementalOptimiser<SE2d> growing;
  const auto none = growing.update();
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().message, "the graph has no poses");
  ASSERT_TRUE(growing.add_pose(SE2d()));
  const auto one = growing.update();
  ASSERT_TRUE(one);
  EXPECT_EQ(one->cost, 0.0);
}

TEST(IncrementalFaults, WaitsForTheEdgeThatConnectsOrDeterminesAPose) {
  Rng rng(16);
  const auto whole = random_walk<SE2d>(rng, 10);
  IncrementalOptimiser<SE2d> growing;
  ASSERT_TRUE(growing.append(whole));
  ASSERT_TRUE(growing.update(kExact));
  const auto before = growing.poses();
  const SE2d ahead(1.0, 0.0, 0.1_rad);
  const int added = *growing.add_pose(before[9] * ahead);
  const auto unconnected = growing.update(kExact);
  ASSERT_FALSE(unconnected);
  EXPECT_THAT(unconnected.error().message, HasSubstr("pose 10 is not connected to pose 0"));
  Eigen::Matrix3d no_heading = Eigen::Vector3d(2.0, 2.0, 0.0).asDiagonal();
  ASSERT_TRUE(growing.add_edge({9, added, ahead, no_heading}));
  for (int again = 0; again < 2; ++again) {
    const auto undetermined = growing.update(kExact);
    ASSERT_FALSE(undetermined);
    EXPECT_EQ(undetermined.error().code, ErrorCode::degenerate);
    EXPECT_EQ(undetermined.error().message,
              "pose 10 is not fully determined by the edges, along (0, 0, 1)");
    ASSERT_FALSE(growing.optimise_fully());
  }
  EXPECT_EQ(apart({growing.poses().begin(), growing.poses().end() - 1}, before), 0.0);
  ASSERT_TRUE(
      growing.add_edge({2, added, before[2].inverse() * before[9] * SE2d(1.1, 0.1, 0.2_rad)}));
  auto batch = growing.graph();
  ASSERT_TRUE(optimise(batch, {.min_relative_gain = 1e-14, .min_absolute_gain = 1e-14}));
  IncrementalOptions options = kExact;
  options.max_rounds = 8;
  ASSERT_TRUE(growing.update(options));
  EXPECT_LT(apart(growing.poses(), batch.poses), 3e-7);
}

TEST(IncrementalFaults, DiscardsPendingAdditions) {
  Rng rng(17);
  const auto whole = random_walk<SE2d>(rng, 10);
  IncrementalOptimiser<SE2d> growing;
  ASSERT_TRUE(growing.append(whole));
  ASSERT_TRUE(growing.update());
  ASSERT_TRUE(growing.add_pose(SE2d(), true));
  ASSERT_TRUE(growing.add_pose(SE2d()));
  ASSERT_FALSE(growing.update());
  growing.discard_pending();
  EXPECT_EQ(growing.graph().size(), 10);
  EXPECT_EQ(growing.graph().fixed, std::vector<int>{0});
  EXPECT_TRUE(growing.update());
}

TEST(IncrementalFaults, RejectsAGraphThatDoesNotExtendItsOwn) {
  Rng rng(18);
  auto grown = random_walk<SE2d>(rng, 10);
  IncrementalOptimiser<SE2d> growing;
  ASSERT_TRUE(growing.append(grown));
  ASSERT_TRUE(growing.update());
  grown.fixed = {4};
  const auto held = growing.append(grown);
  ASSERT_FALSE(held);
  EXPECT_EQ(held.error().message, "pose 4 was free and is fixed now");
  grown.fixed.clear();
  grown.add_pose(SE2d());
  grown.edges.push_back({9, 10, SE2d()});
  grown.edges.push_back({9, 11, SE2d()});
  ASSERT_FALSE(growing.append(grown));
  EXPECT_EQ(growing.graph().size(), 10) << "all or nothing";
  grown.poses.resize(5);
  ASSERT_FALSE(growing.append(grown));
}

}  // namespace
}  // namespace wayfare
