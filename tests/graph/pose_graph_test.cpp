#include <wayfare/graph/pose_graph.hpp>

#include <numbers>

#include <gtest/gtest.h>

namespace wayfare {
namespace {

// Pose 1 is at (3, 1) facing left and was measured at (1, 1) facing forward: the error is
// (2, 0, 90°).
PoseGraph2 pair() {
  PoseGraph2 graph;
  EXPECT_EQ(graph.add_pose(SE2d()), 0);
  EXPECT_EQ(graph.add_pose(SE2d(3.0, 1.0, 90_deg)), 1);
  const Eigen::Matrix3d information = Eigen::Vector3d(5.0, 7.0, 1.0).asDiagonal();
  graph.edges.push_back({0, 1, SE2d(1.0, 1.0, Angle{}), information, true});
  return graph;
}

TEST(PoseGraph, SquaredErrorIsWeighedByTheInformation) {
  auto graph = pair();
  const double turn = std::numbers::pi / 2.0, want = 5.0 * 4.0 + turn * turn;
  EXPECT_NEAR(squared_error(graph, graph.edges[0]), want, 1e-12);
  graph.edges.push_back(graph.edges[0]);
  EXPECT_NEAR(chi2(graph), 2.0 * want, 1e-12);
  // The error does not depend on the common frame.
  for (SE2d& pose : graph.poses) pose = SE2d(-40.0, 7.0, 200_deg) * pose;
  EXPECT_NEAR(chi2(graph), 2.0 * want, 1e-9);
}

TEST(PoseGraph, TheKernelAppliesToRobustEdgesOnly) {
  auto graph = pair();
  const double s = squared_error(graph, graph.edges[0]);
  const RobustKernel cauchy{RobustKernelKind::cauchy, 2.0};
  EXPECT_NEAR(robust_cost(graph, cauchy), 4.0 * std::log1p(s / 4.0), 1e-12);
  graph.edges[0].robust = false;
  EXPECT_EQ(robust_cost(graph, cauchy), s);
  EXPECT_EQ(robust_cost(graph, {}), chi2(graph));
}

TEST(PoseGraph, PosesWithoutLabelsAreNamedByTheirIndex) {
  auto graph = pair();
  EXPECT_EQ(graph.label(1), "1");
  graph.labels = {"start"};
  EXPECT_EQ(graph.label(0), "start");
  EXPECT_EQ(graph.label(1), "1");
  EXPECT_EQ(graph.label(-3), "-3");
}

}  // namespace
}  // namespace wayfare
