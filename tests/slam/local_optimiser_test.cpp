#include <wayfare/slam/detail/graph_slam/local_optimiser.hpp>

#include <gtest/gtest.h>

#include <wayfare/core/random.hpp>

namespace wayfare::detail {
namespace {

constexpr int kSide = 40;  // of the lattice

/// A lattice of poses 1 m apart with noisy edges, at its optimum.
PoseGraph2 noisy_lattice(int rows) {
  Rng rng(3);
  PoseGraph2 graph;
  for (int row = 0; row < rows; ++row)
    for (int column = 0; column < kSide; ++column) graph.add_pose(SE2d(column, row, {}));
  const auto join = [&](int from, int to) {
    const SE2d step = graph.poses[static_cast<std::size_t>(from)].inverse() *
                      graph.poses[static_cast<std::size_t>(to)];
    const Eigen::Vector3d noise(rng.normal(0, 0.02), rng.normal(0, 0.02), rng.normal(0, 0.005));
    graph.edges.push_back(
        {from, to, step * SE2d::exp(noise), Eigen::Vector3d(2500, 2500, 4e4).asDiagonal(), false});
  };
  for (int k = 0; k < graph.size(); ++k) {
    if (k % kSide + 1 < kSide) join(k, k + 1);
    if (k + kSide < graph.size()) join(k, k + kSide);
  }
  EXPECT_TRUE(optimise(graph));
  return graph;
}

double cost_of(const PoseGraph2& graph) {
  double sum = 0.0;
  for (const auto& edge : graph.edges) sum += squared_error(graph, edge);
  return sum;
}

/// A pose beside pose `at`, joined to it, `off_m` from where the edge puts it.
int add_beside(PoseGraph2& graph, int at, double off_m) {
  const SE2d step(0.3, 0.4, Angle::degrees(20));
  const int added =
      graph.add_pose(graph.poses[static_cast<std::size_t>(at)] * step * SE2d(off_m, 0.0, {}));
  graph.edges.push_back({at, added, step, Eigen::Vector3d(2500, 2500, 4e4).asDiagonal(), false});
  return added;
}

TEST(LocalOptimiser, MovesThePosesNearbyToTheOptimum) {
  PoseGraph2 graph = noisy_lattice(kSide);
  const int at = 20 * kSide + 20, added = add_beside(graph, at, 0.2);
  graph.edges.push_back({at + kSide + 1, added, SE2d(-0.66, -0.62, Angle::degrees(20)),
                         Eigen::Vector3d(2500, 2500, 4e4).asDiagonal(), false});
  PoseGraph2 best = graph;
  ASSERT_TRUE(optimise(best));
  const PoseGraph2 before = graph;
  LocalOptimiser local;
  ASSERT_TRUE(local.around(added).optimise(graph, {}));
  EXPECT_LT(cost_of(graph), cost_of(best) * (1.0 + 1e-4));
  EXPECT_EQ(graph.poses[3].translation(), before.poses[3].translation());
  EXPECT_EQ(graph.poses[kSide * kSide - 1].translation(),
            before.poses[kSide * kSide - 1].translation());
}

TEST(LocalOptimiser, OptimisesAllOfASmallGraph) {
  PoseGraph2 graph = noisy_lattice(4);
  const int added = add_beside(graph, 70, 0.3);
  PoseGraph2 best = graph;
  ASSERT_TRUE(optimise(best));
  LocalOptimiser local;
  ASSERT_TRUE(local.around(added).optimise(graph, {}));
  EXPECT_NEAR(cost_of(graph), cost_of(best), 1e-6 * cost_of(best));
}

// The edges of the first pose alone say that it looks one degree to the left: the optimum with that
// pose held turns all others about it, the far corner by 1 m.
TEST(LocalOptimiser, KeepsThePlaceOfTheMapWhereAllPosesAreOptimised) {
  PoseGraph2 graph = noisy_lattice(kSide);
  const PoseGraph2 before = graph;
  const SE2d turn(0.0, 0.0, Angle::degrees(-1));
  for (auto& e : graph.edges)
    if (e.from == 0) e.measurement = turn * e.measurement;
  PoseGraph2 held = graph;
  ASSERT_TRUE(optimise(held));
  const auto moved_m = [&](const PoseGraph2& now, std::size_t k) {
    return (now.poses[k].translation() - before.poses[k].translation()).norm();
  };
  EXPECT_GT(moved_m(held, kSide * kSide - 1), 0.9);
  LocalOptimiser local;
  ASSERT_TRUE(local.everywhere().optimise(graph, {}));
  EXPECT_NEAR(cost_of(graph), cost_of(held), 1e-6 * cost_of(held));
  for (std::size_t k = 0; k < graph.poses.size(); ++k) EXPECT_LT(moved_m(graph, k), 0.01);
  EXPECT_NEAR((before.poses[0].inverse() * graph.poses[0]).heading().degrees(), 1.0, 0.01);
}

TEST(LocalOptimiser, LeavesThePosesWhereTheGraphIsInError) {
  PoseGraph2 graph = noisy_lattice(4);
  const int alone = graph.add_pose(SE2d(5, 5, {}));
  const PoseGraph2 before = graph;
  LocalOptimiser local;
  EXPECT_FALSE(local.around(alone).optimise(graph, {}));
  EXPECT_FALSE(local.everywhere().optimise(graph, {}));
  for (std::size_t k = 0; k < graph.poses.size(); ++k)
    EXPECT_EQ(graph.poses[k].translation(), before.poses[k].translation());
}

}  // namespace
}  // namespace wayfare::detail
