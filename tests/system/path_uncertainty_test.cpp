#include <wayfare/graph/path_uncertainty.hpp>

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
TEST(PathUncertainty, AddsUpAlongAChainAsGaussiansDo) {
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

TEST(PathUncertainty, IsTheSameWhicheverWayAnEdgePoints) {
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

TEST(PathUncertainty, TakesTheBetterOfTwoWaysAndLeavesUnusableEdgesOut) {
  PoseGraph2 graph;
  for (int k = 0; k < 4; ++k) graph.add_pose({});
  const Eigen::Matrix3d loose = Eigen::Matrix3d::Identity(), tight = 100.0 * loose;
  graph.edges = {{0, 1, {}, loose, false}, {0, 2, {}, tight, false}, {2, 1, {}, tight, true}};
  EXPECT_NEAR(path_uncertainty(graph, 0, kAll).covariance[1](0, 0), 0.02, 1e-12);
  const auto sure = path_uncertainty(graph, 0, [](const auto& e) { return !e.robust; });
  EXPECT_NEAR(sure.covariance[1](0, 0), 1.0, 1e-12);
  EXPECT_FALSE(sure.reached(3));
}

}  // namespace
}  // namespace wayfare
