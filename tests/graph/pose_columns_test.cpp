#include <wayfare/graph/detail/normal_equations.hpp>

#include <gtest/gtest.h>

#include <wayfare/graph/optimise.hpp>
#include <wayfare/graph/pose_graph.hpp>

namespace wayfare {
namespace {

TEST(VariableColumns, FreePosesAreNumberedInOrder) {
  PoseGraph2 graph;
  for (int i = 0; i < 5; ++i) graph.add_pose(SE2d());
  VariableColumns columns;
  columns.number(graph.size(), graph.held());
  EXPECT_EQ(columns.free(), (std::vector<int>{1, 2, 3, 4}));
  graph.fixed = {3, 1, 3};
  columns.number(graph.size(), graph.held());
  EXPECT_EQ(columns.free(), (std::vector<int>{0, 2, 4}));
  EXPECT_EQ(columns.of(2), 1);
  EXPECT_EQ(columns.of(3), -1);
  EXPECT_EQ(columns.size(), 5);
}

// No free pose: no error, and nothing moves.
TEST(VariableColumns, ASinglePoseIsItsOwnOptimumAndStart) {
  PoseGraph2 graph{{SE2d(1.0, 2.0, Angle{})}, {}, {}, {}};
  PoseGraphOptimiser<SE2d> optimiser;
  const auto report = optimiser.optimise(graph);
  ASSERT_TRUE(report) << report.error().to_string();
  EXPECT_EQ(report->iterations, 0);
  EXPECT_EQ(report->final_chi2, 0.0);
  for (const auto method : {StartMethod::odometry, StartMethod::tree, StartMethod::chordal})
    EXPECT_TRUE(start_from(graph, method));
  EXPECT_EQ(graph.poses[0].x(), 1.0);
  ASSERT_TRUE(optimiser.prepare_covariances(graph));
  EXPECT_EQ(optimiser.covariance(0).norm(), 0.0);
}

}  // namespace
}  // namespace wayfare
