// A public graph replayed edge by edge with the default thresholds.

#include <wayfare/graph/incremental.hpp>

#include <array>
#include <string>

#include <gtest/gtest.h>

#include <wayfare/graph/optimise.hpp>
#include <wayfare/io/g2o.hpp>

#include "io/support.hpp"

namespace wayfare {
namespace {

TEST(IncrementalReplay, AddsEachPoseWithItsFirstEdge) {
  PoseGraph<SE2d> graph;
  for (int i = 0; i < 4; ++i) graph.add_pose(SE2d(i, 0.0, 0.0_rad));
  const auto edge = [&](int from, int to) {
    graph.edges.push_back({from, to, SE2d(to - from, 0.0, 0.0_rad)});
  };
  edge(3, 0), edge(2, 3), edge(1, 0), edge(0, 2), edge(1, 2);
  std::vector<std::array<int, 3>> got;
  std::vector<SE2d> poses{graph.poses[0]};
  for (const auto& step : replay_steps(graph)) {
    got.push_back({step.edge.from, step.edge.to, step.new_pose});
    if (step.new_pose >= 0) poses.push_back(step.placed(poses));
  }
  EXPECT_EQ(got, (std::vector<std::array<int, 3>>{
                     {1, 0, 1}, {1, 2, 2}, {0, 2, -1}, {2, 3, 3}, {3, 0, -1}}));
  for (int i = 0; i < 4; ++i) EXPECT_NEAR(poses[static_cast<std::size_t>(i)].x(), i, 1e-12);
}

class ReplayedGraph : public ::testing::TestWithParam<const char*> {};

// Bounds of the cost with the default options and of the work: on average less than a tenth of the
// columns.
TEST_P(ReplayedGraph, StaysNearTheBatchOptimumAtATenthOfTheWork) {
  WAYFARE_NEEDS_RECORDING(path, std::string("posegraph/") + GetParam() + ".g2o.gz");
  const auto file = io::read_g2o(path);
  ASSERT_TRUE(file) << file.error().to_string();
  const auto whole = io::to_pose_graph(std::get<io::GraphFile<SE2d>>(*file));
  IncrementalOptimiser<SE2d> growing;
  ASSERT_TRUE(growing.add_pose(whole.poses[0]));
  PoseGraph<SE2d> batch = growing.graph();
  PoseGraphOptimiser<SE2d> optimiser;
  double refactored = 0.0, columns = 0.0;
  int step_number = 0;
  for (const auto& step : replay_steps(whole)) {
    if (step.new_pose >= 0) {
      ASSERT_TRUE(growing.add_pose(step.placed(growing.poses())));
      batch.add_pose(step.placed(batch.poses));
    }
    ASSERT_TRUE(growing.add_edge(step.edge));
    batch.edges.push_back(step.edge);
    const auto report = growing.update();
    ASSERT_TRUE(report);
    refactored += report->refactored;
    columns += growing.graph().size();
    if (++step_number % 250 != 0) continue;
    const auto best = optimiser.optimise(batch);
    ASSERT_TRUE(best);
    ASSERT_LE(report->cost, 1.01 * best->final_cost + 1e-6) << "edge " << step_number;
  }
  EXPECT_LT(refactored, 0.1 * columns);
}

INSTANTIATE_TEST_SUITE_P(Public, ReplayedGraph, ::testing::Values("intel", "M3500"));

}  // namespace
}  // namespace wayfare
