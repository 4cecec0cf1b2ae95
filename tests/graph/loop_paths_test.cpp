// Shortest paths of loops over a growing set of edges, compared with Floyd's and with composition.

#include "graph/consistency/cycles.hpp"

#include <algorithm>
#include <array>
#include <numeric>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include <wayfare/core/random.hpp>

namespace wayfare::detail {
namespace {

constexpr int kPoses = 60, kChords = 12;
constexpr double kVariance = 0.04;

/// A chain of poses, some edges of it reversed, without rotation, so that variances add. Then
/// loops.
PoseGraph<SE2d> chain_with_loops(Rng& rng, int loops) {
  PoseGraph<SE2d> graph;
  for (int k = 0; k < kPoses; ++k)
    graph.poses.push_back(SE2d(0.5 * k, rng.normal(0.0, 1.0), Angle()));
  const auto join = [&](int a, int b, bool robust) {
    PoseEdge<SE2d> edge;
    edge.from = a, edge.to = b, edge.robust = robust;
    edge.measurement = graph.poses[at(a)].inverse() * graph.poses[at(b)];
    // The heading is nearly exact, as it would add to the variances of positions.
    edge.information = Eigen::Vector3d(1.0 / kVariance, 1.0 / kVariance, 1e9).asDiagonal();
    graph.edges.push_back(edge);
  };
  for (int k = 1; k < kPoses; ++k) k % 3 == 0 ? join(k, k - 1, false) : join(k - 1, k, false);
  for (int k = 0; k < loops; ++k) {
    const int a = static_cast<int>(rng.below(kPoses - 2));
    join(a, a + 2 + static_cast<int>(rng.below(kPoses - a - 2)), true);
  }
  return graph;
}

/// Number of edges between all poses, by Floyd and Warshall.
std::vector<std::vector<int>> distances(const PoseGraph<SE2d>& graph,
                                        const std::vector<int>& accepted) {
  std::vector<std::vector<int>> d(kPoses, std::vector<int>(kPoses, kPoses));
  for (int k = 0; k < kPoses; ++k) d[at(k)][at(k)] = 0;
  for (const int k : accepted) {
    const auto& e = graph.edges[at(k)];
    d[at(e.from)][at(e.to)] = d[at(e.to)][at(e.from)] = 1;
  }
  for (std::size_t via = 0; via < kPoses; ++via)
    for (auto& row : d)
      for (std::size_t to = 0; to < kPoses; ++to)
        row[to] = std::min(row[to], row[via] + d[via][to]);
  return d;
}

class LoopPathsOf : public ::testing::TestWithParam<int> {};

TEST_P(LoopPathsOf, AcceptedEdgesAreTheShortest) {
  Rng rng(static_cast<std::uint64_t>(GetParam()));
  const PoseGraph<SE2d> graph = chain_with_loops(rng, 40 + kChords);
  std::vector<int> accepted(kPoses - 1), loops(40);
  std::iota(accepted.begin(), accepted.end(), 0);
  std::iota(loops.begin(), loops.end(), kPoses - 1);
  LoopPaths<SE2d> paths(graph);
  paths.accept(accepted);

  const auto check = [&](int loop, const LoopPath<SE2d>& path) {
    const PoseEdge<SE2d>& edge = graph.edges[at(loop)];
    EXPECT_LT(path.across.minus(edge.measurement).norm(), 1e-9);
    const double variance = kVariance * paths.edges(loop);
    EXPECT_NEAR(path.covariance(0, 0), variance, 1e-3);
    EXPECT_NEAR(path.covariance(1, 1), variance, 1e-3);
  };
  LoopPath<SE2d> path;
  for (const int k : loops) {
    ASSERT_TRUE(paths.find(k, kPoses, path));
    check(k, path);
  }
  // Chords are accepted in batches of one to three.
  for (int first = 99, size = 1; first < 99 + kChords; first += size, size = 1 + size % 3) {
    std::vector<int> batch;
    for (int k = first; k < std::min(first + size, 99 + kChords); ++k) batch.push_back(k);
    accepted.insert(accepted.end(), batch.begin(), batch.end());
    paths.accept(batch);
    const std::vector<int> affected = paths.affected(batch, loops, kPoses);
    std::vector<int> poses;
    for (const int k : batch) poses.push_back(graph.edges[at(k)].from);
    paths.shorten(poses, kPoses, affected, check);
    const auto shortest = distances(graph, accepted);
    for (const int k : loops)
      EXPECT_EQ(paths.edges(k), shortest[at(graph.edges[at(k)].from)][at(graph.edges[at(k)].to)]);
  }
}

INSTANTIATE_TEST_SUITE_P(Seeds, LoopPathsOf, ::testing::Range(1, 9));

TEST(LoopPaths, ThereIsNoPathOfFewerHops) {
  Rng rng(1);
  PoseGraph<SE2d> graph = chain_with_loops(rng, 1);
  graph.edges.back().from = 10, graph.edges.back().to = 30;
  std::vector<int> chain(kPoses - 1);
  std::iota(chain.begin(), chain.end(), 0);
  LoopPaths<SE2d> paths(graph);
  paths.accept(chain);
  LoopPath<SE2d> path;
  EXPECT_FALSE(paths.find(kPoses - 1, 19, path));
  EXPECT_EQ(paths.edges(kPoses - 1), LoopPaths<SE2d>::kNone);
  EXPECT_TRUE(paths.find(kPoses - 1, 20, path));
  EXPECT_EQ(paths.edges(kPoses - 1), 20);
}

/// The chain's sums against the covariances composed edge by edge, in both directions.
TEST(LoopPaths, TheChainIsComposedFromItsEdges) {
  Rng rng(5);
  PoseGraph<SE3d> graph;
  const auto random = [&](double sigma) {
    TangentOf<SE3d> v;
    for (int k = 0; k < 6; ++k) v[k] = rng.normal(0.0, sigma);
    return v;
  };
  for (int k = 0; k < 20; ++k) {
    graph.poses.push_back(k == 0 ? SE3d() : graph.poses.back() * SE3d::exp(random(0.5)));
    if (k == 0) continue;
    const auto [from, to] = k % 4 == 1 ? std::pair(k, k - 1) : std::pair(k - 1, k);
    PoseEdge<SE3d> edge;
    edge.from = from, edge.to = to;
    edge.measurement = graph.poses[at(from)].inverse() * graph.poses[at(to)];
    SquareOf<SE3d> root = SquareOf<SE3d>::Identity() * 10.0;
    root.col(0) += random(1.0);
    edge.information = root * root.transpose();
    graph.edges.push_back(edge);
  }
  const LoopPaths<SE3d> paths(graph);
  for (const auto& [from, to] : std::array{std::pair(2, 17), std::pair(15, 3)}) {
    LoopPath<SE3d> sum{SE3d(), SquareOf<SE3d>::Zero(), 0.0};
    for (int k = from; k != to; k += from < to ? 1 : -1) {
      const int next = k + (from < to ? 1 : -1), edge = std::max(k, next) - 1;
      const PoseEdge<SE3d>& e = graph.edges[at(edge)];
      const bool forwards = e.from == k;
      const SE3d step = forwards ? e.measurement : e.measurement.inverse();
      const SquareOf<SE3d> move = step.inverse().adjoint();
      const SquareOf<SE3d> own = paths.covariance(edge), turn = e.measurement.adjoint();
      sum.covariance = move * sum.covariance * move.transpose() +
                       (forwards ? own : SquareOf<SE3d>(turn * own * turn.transpose()));
      sum.across = sum.across * step;
      sum.length += step.translation().norm();
    }
    const LoopPath<SE3d> chain = paths.along_chain(from, to);
    EXPECT_LT(chain.across.minus(sum.across).norm(), 1e-12);
    EXPECT_LT((chain.covariance - sum.covariance).norm(), 1e-12 * sum.covariance.norm() + 1e-14);
    EXPECT_NEAR(chain.length, sum.length, 1e-12);
  }
}

}  // namespace
}  // namespace wayfare::detail
