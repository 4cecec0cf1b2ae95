#include <wayfare/graph/path_uncertainty.hpp>

#include <vector>

#include <gtest/gtest.h>

#include <wayfare/core/gaussian.hpp>
#include <wayfare/core/random.hpp>

namespace wayfare {
namespace {

constexpr auto kAll = [](const PoseEdge<SE2d>&) { return true; };

Eigen::Matrix3d random_covariance(Rng& rng) {
  Eigen::Matrix3d a;
  for (auto& v : a.reshaped()) v = rng.uniform(-0.1, 0.1);
  return a * a.transpose() + 1e-4 * Eigen::Matrix3d::Identity();
}

SE2d random_step(Rng& rng) {
  return SE2d(rng.uniform(-1, 1), rng.uniform(-1, 1), Angle::radians(rng.uniform(-2, 2)));
}

// The oracle is the composition of independent uncertain poses (core/gaussian.hpp).
TEST(PathUncertainty, AccumulatesAlongAChainLikeGaussians) {
  Rng rng(7);
  PoseGraph2 graph;
  graph.add_pose({});
  Gaussian<SE2d> sum{SE2d(), Eigen::Matrix3d::Zero()};
  for (int k = 0; k < 6; ++k) {
    const Gaussian<SE2d> step{random_step(rng), random_covariance(rng)};
    graph.add_pose(graph.poses.back() * step.mean);
    graph.edges.push_back({k, k + 1, step.mean, step.covariance.inverse(), false});
    sum = compose(sum, step);
    const auto known = path_uncertainty(graph, 0, kAll);
    EXPECT_LT((known.covariance.back() - sum.covariance).norm(), 1e-9 * sum.covariance.norm());
  }
}

TEST(PathUncertainty, DoesNotDependOnTheDirectionOfAnEdge) {
  Rng rng(8);
  const Gaussian<SE2d> step{random_step(rng), random_covariance(rng)};
  PoseGraph2 forward;
  forward.add_pose({});
  forward.add_pose(step.mean);
  PoseGraph2 backward = forward;
  forward.edges.push_back({0, 1, step.mean, step.covariance.inverse(), false});
  // X₁⁻¹X₀ = Z⁻¹: its right perturbation is −Ad(Z) of that of Z.
  const Eigen::Matrix3d move = step.mean.adjoint();
  const Eigen::Matrix3d inverse_covariance = move * step.covariance * move.transpose();
  backward.edges.push_back({1, 0, step.mean.inverse(), inverse_covariance.inverse(), false});
  const auto a = path_uncertainty(forward, 0, kAll), b = path_uncertainty(backward, 0, kAll);
  EXPECT_LT((a.covariance[1] - b.covariance[1]).norm(), 1e-9 * a.covariance[1].norm());
}

TEST(PathUncertainty, UsesTheBetterOfTwoPathsAndIgnoresUnusableEdges) {
  PoseGraph2 graph;
  for (int k = 0; k < 4; ++k) graph.add_pose({});
  const Eigen::Matrix3d loose = Eigen::Matrix3d::Identity(), tight = 100.0 * loose;
  graph.edges = {{0, 1, {}, loose, false}, {0, 2, {}, tight, false}, {2, 1, {}, tight, true}};
  EXPECT_NEAR(path_uncertainty(graph, 0, kAll).covariance[1](0, 0), 0.02, 1e-12);
  const auto sure = path_uncertainty(graph, 0, [](const auto& e) { return !e.robust; });
  EXPECT_NEAR(sure.covariance[1](0, 0), 1.0, 1e-12);
  EXPECT_FALSE(sure.reached(3));
}

// Chains, shortcuts and unusable edges, appended a few at a time, with poses that move in between.
TEST(PathUncertainty, OfAGrowingGraphEqualsThatOfANewOne) {
  Rng rng(9);
  PoseGraph2 graph;
  graph.add_pose({});
  PathUncertaintyFinder finder;
  const auto near = [&](const PoseEdge<SE2d>& e) {
    return !e.robust || squared_error(graph, e) < 20;
  };
  std::size_t doubted = 0;
  for (int k = 1; k < 60; ++k) {
    graph.add_pose(graph.poses.back() * random_step(rng));
    const auto any = static_cast<int>(rng.below(k));
    for (const int from : {k - 1, any}) {
      const SE2d measured = graph.poses[static_cast<std::size_t>(from)].inverse() *
                            graph.poses.back() * SE2d::exp(0.05 * Eigen::Vector3d::Ones());
      graph.edges.push_back({from, k, measured, random_covariance(rng).inverse(), from != k - 1});
    }
    if (k % 3 != 0) continue;
    for (SE2d& pose : graph.poses) pose = pose.plus(0.02 * random_step(rng).log());
    for (const auto& e : graph.edges) doubted += !near(e);
    const int root = static_cast<int>(rng.below(k + 1));
    const PathUncertainty& grown = finder.find(graph, root, near);
    const PathUncertainty fresh = path_uncertainty(graph, root, near);
    EXPECT_EQ(grown.size, fresh.size);
    EXPECT_EQ(grown.covariance, fresh.covariance);
  }
  EXPECT_GT(doubted, 0U);
}

// With an uncertain heading, a position to the side and back again: errors cancel, and the least
// uncertain chain must still be found. The oracle relaxes every edge until nothing changes.
TEST(PathUncertainty, FindsTheMinimumWhereErrorsCancel) {
  Rng rng(10);
  for (int round = 0; round < 30; ++round) {
    PoseGraph2 graph;
    for (int k = 0; k < 12; ++k) graph.add_pose(SE2d(rng.uniform(-5, 5), rng.uniform(-5, 5), {}));
    for (int k = 0; k < 30; ++k) {
      const auto from = static_cast<int>(rng.below(12)), to = static_cast<int>(rng.below(12));
      if (from != to)
        graph.edges.push_back({from, to, {}, random_covariance(rng).inverse(), false});
    }
    const PathUncertainty known = path_uncertainty(graph, 0, kAll);
    for (const auto& e : graph.edges) {
      const auto from = static_cast<std::size_t>(e.from), to = static_cast<std::size_t>(e.to);
      if (!known.reached(e.from)) {
        EXPECT_FALSE(known.reached(e.to));
        continue;
      }
      const Eigen::Matrix3d move = (graph.poses[to].inverse() * graph.poses[from]).adjoint();
      const Eigen::Matrix3d by_this = move * known.covariance[from] * move.transpose() +
                                      Eigen::Matrix3d(e.information.inverse());
      EXPECT_LT(known.size[to], (by_this(0, 0) + by_this(1, 1) + 4 * by_this(2, 2)) * (1 + 1e-9));
    }
  }
}

/// A path with shortcuts, all edges equally uncertain.
PoseGraph2 path_with_shortcuts(int poses) {
  PoseGraph2 graph;
  for (int k = 0; k < poses; ++k) graph.add_pose(SE2d(0.5 * k, 0.0, {}));
  const auto join = [&](int from, int to) {
    graph.edges.push_back({from, to, SE2d(0.5 * (to - from), 0.0, {}),
                           Eigen::Vector3d(400, 400, 4e4).asDiagonal(), false});
  };
  for (int k = 1; k < poses; ++k) join(k - 1, k);
  for (int k = 10; k < poses; k += 10) join(k - 10, k);
  return graph;
}

TEST(PathUncertainty, EndsWhenPosesAreSettledAsAsked) {
  const PoseGraph2 graph = path_with_shortcuts(100);
  const PathUncertainty all = path_uncertainty(graph, 30, kAll);
  PathUncertaintyFinder finder;
  std::vector<int> settled;
  const PathUncertainty& some = finder.find(graph, 30, kAll, [&](int pose) {
    settled.push_back(pose);
    return pose == 45;
  });
  EXPECT_EQ(settled.front(), 30);
  EXPECT_EQ(settled.back(), 45);
  EXPECT_LT(settled.size(), 60U);
  for (const int pose : settled)
    EXPECT_EQ(some.size[static_cast<std::size_t>(pose)], all.size[static_cast<std::size_t>(pose)]);
  EXPECT_FALSE(some.reached(99));
}

TEST(PathUncertainty, ForgetsAGraphThatHasChanged) {
  PoseGraph2 graph = path_with_shortcuts(60);
  PathUncertaintyFinder finder;
  (void)finder.find(graph, 0, kAll);
  graph.edges.erase(graph.edges.begin() + 58, graph.edges.end());  // the last pose and shortcuts
  graph.poses.pop_back();
  graph.edges[7].information *= 0.25;
  finder.forget();
  const PathUncertainty changed = finder.find(graph, 0, kAll);
  EXPECT_EQ(changed.size, path_uncertainty(graph, 0, kAll).size);
}

}  // namespace
}  // namespace wayfare
