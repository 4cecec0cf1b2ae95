#include <wayfare/graph/incremental.hpp>

#include <algorithm>
#include <cstdint>
#include <vector>

#include <gtest/gtest.h>

#include <wayfare/graph/optimise.hpp>

#include "growth.hpp"

namespace wayfare {
namespace {

using tests::apart;
using tests::kExact;
using tests::random_walk;

/// Adds one edge, and its new pose at the last estimate.
template <class G>
void take(IncrementalOptimiser<G>& growing, const ReplayStep<G>& step) {
  if (step.new_pose >= 0) {
    ASSERT_TRUE(growing.add_pose(step.placed(growing.poses())));
  }
  ASSERT_TRUE(growing.add_edge(step.edge));
}

template <class G>
class IncrementalTest : public ::testing::Test {};
using Groups = ::testing::Types<SE2d, SE3d>;
TYPED_TEST_SUITE(IncrementalTest, Groups);

// With zero thresholds, at every step, with and without a robust kernel.
TYPED_TEST(IncrementalTest, EqualsABatchStepIfAllIsRelinearised) {
  using G = TypeParam;
  for (const RobustKernel kernel : {RobustKernel{}, RobustKernel{RobustKernelKind::cauchy, 2.0}}) {
    Rng rng(11);
    const auto whole = random_walk<G>(rng, 60, kernel.kind != RobustKernelKind::none);
    IncrementalOptimiser<G> growing(kernel);
    ASSERT_TRUE(growing.add_pose(whole.poses[0]));
    int compared = 0;
    for (const auto& step : replay_steps(whole)) {
      take(growing, step);
      auto batch = growing.graph();
      DampedStep<PoseGraph<G>, DefaultSolver<G::kDof>> whole_step;
      whole_step.prepare(batch);
      whole_step.linearise(batch, kernel);
      ASSERT_TRUE(whole_step.compute(0.0));
      whole_step.apply(batch);
      const auto report = growing.update(kExact);
      ASSERT_TRUE(report);
      EXPECT_NEAR(report->cost, robust_cost(growing.graph(), kernel), 1e-9 * (1.0 + report->cost));
      if (report->fell_back) continue;
      ++compared;
      ASSERT_LT(apart(growing.poses(), batch.poses), 1e-9) << "edge " << compared;
    }
    EXPECT_GT(compared, 60);
  }
}

TYPED_TEST(IncrementalTest, FindsTheSameOptimumForAnySplitOfTheGraph) {
  using G = TypeParam;
  Rng rng(12);
  const auto whole = random_walk<G>(rng, 50);
  auto batch = whole;
  ASSERT_TRUE(optimise(batch, {.min_relative_gain = 1e-14, .min_absolute_gain = 1e-14}));
  for (const std::size_t at_a_time : {1U, 4U, 17U, 1000U}) {
    for (const double reorder_work : {0.0, 20.0, 1e9}) {  // always, sometimes, never
      IncrementalOptimiser<G> growing;
      IncrementalOptions options = kExact;
      options.reorder_work = reorder_work;
      ASSERT_TRUE(growing.add_pose(whole.poses[0]));
      std::size_t taken = 0;
      for (const auto& step : replay_steps(whole)) {
        take(growing, step);
        if (++taken % at_a_time == 0) {
          ASSERT_TRUE(growing.update(options));
        }
      }
      options.max_rounds = 8;
      ASSERT_TRUE(growing.update(options));
      // The cost is about a hundred, and the batch optimiser stops within 1e-14 of it; with
      // informations above 20, steps of up to sqrt(1e-12 / 20) remain.
      EXPECT_LT(apart(growing.poses(), batch.poses), 3e-7);
    }
  }
}

TYPED_TEST(IncrementalTest, ConvergesToTheBatchOptimumOfAGrowingGraph) {
  using G = TypeParam;
  Rng rng(13);
  auto whole = random_walk<G>(rng, 40);
  whole.fixed = {3, 20};
  PoseGraph<G> grown;
  grown.fixed = whole.fixed;
  IncrementalOptimiser<G> growing;
  for (const std::size_t poses : {25U, 33U, 40U}) {
    grown.poses.assign(whole.poses.begin(), whole.poses.begin() + static_cast<long>(poses));
    std::erase_if(grown.edges, [](const auto&) { return true; });
    for (const auto& e : whole.edges)
      if (static_cast<std::size_t>(std::max(e.from, e.to)) < poses) grown.edges.push_back(e);
    ASSERT_TRUE(growing.append(grown));
    ASSERT_TRUE(growing.update());
  }
  for (const std::size_t held : {3U, 20U})
    EXPECT_EQ(apart<G>({growing.poses()[held]}, {whole.poses[held]}), 0.0);
  auto batch = growing.graph();
  const auto expected = optimise(batch);
  const auto report = growing.optimise_fully();
  ASSERT_TRUE(expected && report);
  EXPECT_EQ(apart(growing.poses(), batch.poses), 0.0);
  EXPECT_EQ(report->final_cost, expected->final_cost);
  const auto still = growing.update();
  ASSERT_TRUE(still);
  EXPECT_NEAR(still->cost, report->final_cost, 1e-6 * report->final_cost);
}

TYPED_TEST(IncrementalTest, IsDeterministic) {
  using G = TypeParam;
  std::vector<G> first;
  for (int run = 0; run < 2; ++run) {
    Rng rng(14);
    const auto whole = random_walk<G>(rng, 80);
    IncrementalOptimiser<G> growing;
    ASSERT_TRUE(growing.add_pose(whole.poses[0]));
    for (const auto& step : replay_steps(whole)) {
      take(growing, step);
      ASSERT_TRUE(growing.update());
    }
    if (run == 1) {
      EXPECT_EQ(apart(first, growing.poses()), 0.0);
    }
    first = growing.poses();
  }
}

// The cost of small changes does not depend on the size of the graph. A column of r numbers of the
// factor costs r² multiplications and additions; the n of the last poses are a full triangle.
TYPED_TEST(IncrementalTest, CostsNoMoreForALongChainThanForAShortOne) {
  using G = TypeParam;
  IncrementalOptimiser<G> growing;
  const G step = G::exp(TangentOf<G>::Constant(0.1));
  ASSERT_TRUE(growing.add_pose(G()));
  for (int i = 0; i < 1000; ++i) {
    ASSERT_TRUE(growing.add_pose(growing.poses().back() * step));
    ASSERT_TRUE(growing.add_edge({i, i + 1, step}));
    const auto report = growing.update();
    ASSERT_TRUE(report);
    EXPECT_LE(report->refactored, 2) << i;
    EXPECT_LE(report->substituted, 2) << i;
    EXPECT_EQ(report->relinearised, 0) << i;
    EXPECT_EQ(report->rounds, 1) << i;
    const double n = G::kDof * report->refactored;
    EXPECT_NEAR(report->flops, n * (n + 1.0) * (2.0 * n + 1.0) / 6.0, 1e-9) << i;
  }
}

// Initial values so far off that the full step raises the cost.
TYPED_TEST(IncrementalTest, FallsBackToTheBatchOptimiserInsteadOfRaisingTheCost) {
  using G = TypeParam;
  int fell_back = 0;
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    Rng rng(seed);
    auto whole = random_walk<G>(rng, 12);
    for (auto& pose : whole.poses) pose = pose.plus(tests::random_tangent<G>(rng, 2.5));
    const double before = chi2(whole);
    IncrementalOptimiser<G> growing;
    ASSERT_TRUE(growing.append(whole));
    const auto report = growing.update(kExact);
    ASSERT_TRUE(report);
    EXPECT_LE(report->cost, 1.01 * before);
    EXPECT_NEAR(report->cost, chi2(growing.graph()), 1e-9 * report->cost);
    fell_back += report->fell_back ? 1 : 0;
  }
  EXPECT_GT(fell_back, 0);
}

}  // namespace
}  // namespace wayfare
