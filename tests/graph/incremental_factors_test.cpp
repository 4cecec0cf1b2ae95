// The incremental optimiser on factor graphs, beside the batch optimiser.

#include <wayfare/graph/incremental.hpp>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include <wayfare/graph/optimise.hpp>

#include "factor_worlds.hpp"

namespace wayfare {
namespace {

using tests::apart;
using tests::Both;
using tests::cost_of;
using tests::kNan;
using tests::kStep;
using tests::same;
using tests::Scalar;
using tests::Walk;

/// The batch optimiser's Gauss-Newton step, if it is determined.
template <class Graph>
Result<Graph> whole_step(const Graph& graph) {
  Graph moved = graph;
  if (auto valid = validate(moved); !valid) return valid.error();
  DampedStep<Graph, DefaultSolver<Graph::kBlock>> step;
  step.prepare(moved);
  step.linearise(moved, {});
  if (step.equations().free().empty()) return moved;
  if (!step.compute(0.0)) return step.undetermined(moved);
  step.apply(moved);
  return moved;
}

template <class Kind>
class IncrementalFactors : public ::testing::Test {};
using Kinds = ::testing::Types<tests::Trees, tests::ScaledWheels, tests::Space>;
TYPED_TEST_SUITE(IncrementalFactors, Kinds);

// With zero thresholds every update is a step of the batch optimiser.
TYPED_TEST(IncrementalFactors, EqualsABatchStepIfAllIsRelinearised) {
  Walk<TypeParam> walk(21);
  Both<typename TypeParam::Graph> g;
  int compared = 0;
  for (int i = 0; i < 50; ++i) {
    walk.grow(g);
    const auto expected = whole_step(g.model);
    const auto report = g.tested.update(kStep);
    ASSERT_EQ(static_cast<bool>(report), static_cast<bool>(expected)) << i;
    if (!report) continue;
    const auto& graph = g.tested.graph();
    EXPECT_NEAR(report->cost, cost_of(graph), 1e-9 * (1.0 + report->cost));
    if (!report->fell_back) {
      ASSERT_LT(apart(graph, *expected), 1e-8) << i;
      ++compared;
    }
    g.model.set_values(graph.values());
  }
  EXPECT_GT(compared, 30);
}

// Repeated steps end at the cost of the batch optimiser's optimum, at every stage of the graph.
TYPED_TEST(IncrementalFactors, AgreesWithRepeatedBatchOptimisation) {
  for (const std::uint64_t seed : {22U, 23U}) {
    Walk<TypeParam> walk(seed);
    Both<typename TypeParam::Graph> g;
    auto batch = g.model;
    IncrementalOptions options = kStep;
    options.max_rounds = 30;
    options.relinearise_step = 1e-9;
    for (int i = 0; i < 40; ++i) {
      walk.grow(g);
      const auto report = g.tested.update(options);
      if (!report || i % 5 != 0) continue;
      batch = g.model;
      const auto expected =
          optimise(batch, {.min_relative_gain = 1e-12, .min_absolute_gain = 1e-12});
      ASSERT_TRUE(expected);
      EXPECT_NEAR(report->cost, expected->final_cost, 1e-6 * expected->final_cost + 1e-10) << i;
    }
    g.model.set_values(g.tested.graph().values());
    EXPECT_GT(cost_of(g.model), 1.0);
  }
}

// With the default thresholds the cost stays near the optimum.
TYPED_TEST(IncrementalFactors, StaysNearTheOptimumAtDefaultThresholds) {
  Walk<TypeParam> walk(24);
  Both<typename TypeParam::Graph> g;
  double last = 0.0;
  for (int i = 0; i < 60; ++i) {
    walk.grow(g);
    if (const auto report = g.tested.update()) last = report->cost;
  }
  auto batch = g.tested.graph();
  const auto expected = optimise(batch);
  ASSERT_TRUE(expected);
  EXPECT_LT(last, 1.02 * expected->final_cost);
}

// Copies go on alike, and the batch optimiser inside gives the same bytes on any number of threads.
TYPED_TEST(IncrementalFactors, IsDeterministicForAnyNumberOfThreads) {
  Both<typename TypeParam::Graph> first;
  for (const int threads : {1, 2, 5}) {
    Walk<TypeParam> walk(25);
    Both<typename TypeParam::Graph> g;
    for (int i = 0; i < 40; ++i) {
      walk.grow(g);
      (void)g.tested.update();
      if (i % 13 == 12) {
        ASSERT_TRUE(g.tested.optimise_fully({.threads = threads}));
      }
      if (i % 7 == 0) g.tested = Both<typename TypeParam::Graph>(g).tested;
    }
    if (threads == 1) first = g;
    EXPECT_TRUE(same(first.tested.graph(), g.tested.graph())) << threads;
  }
}

// The shipped laws, on a walk whose trees are seen from every other pose.
TEST(IncrementalLaws, HoldForTreesOfAWalk) {
  using Graph = tests::Trees::Graph;
  testing::IncrementalLaws<Graph>{[](int step, Graph& graph) {
    const SE2d motion(1.0, 0.02 * (step % 3), Angle::degrees(12.0));
    const auto pose = graph.add(
        step == 0 ? SE2d() : graph.all<SE2d>().back() * SE2d(0.95, 0.0, Angle::degrees(13.0)));
    if (step == 0) graph.fix(pose);
    static VariableId<SE2d> last;
    static VariableId<Eigen::Vector2d> tree;
    if (step == 0) tree = graph.add(Eigen::Vector2d(1.0, 5.0));
    const Eigen::Matrix3d information = Eigen::Vector3d(2500, 2500, 1e4).asDiagonal();
    if (step > 0) graph.add(Between<SE2d>{motion, information}, last, pose);
    last = pose;
    const double bearing = 1.4 - 0.01 * (step % 5);
    if (step % 2 == 0)
      graph.add(
          Robust{BearingRange{Angle::radians(bearing), 4.8, 100.0 * Eigen::Matrix2d::Identity()},
                 RobustKernel{RobustKernelKind::huber, 3.0}},
          pose, tree);
  }}.check();
}

// Random calls: duplicated edges, points far from where they are seen, refused edges, discards and
// whole graphs. What is refused leaves no trace; what is accepted is solved as the batch optimiser
// solves it, or refused by both.
TYPED_TEST(IncrementalFactors, RandomCallsAreThoseOfABatchSolvedGraph) {
  using Graph = typename TypeParam::Graph;
  using Point = typename TypeParam::Point;
  int updates = 0, refusals = 0;
  for (std::uint64_t seed = 100; seed < 160; ++seed) {
    Walk<TypeParam> walk(seed);
    Both<Graph> g;
    Graph solved;
    std::string calls;
    SCOPED_TRACE("seed " + std::to_string(seed));
    for (int k = 0; k < 40; ++k) {
      switch (walk.rng().below(9)) {
        case 0:
        case 1:
        case 2:
          walk.grow(g);
          break;
        case 3:  // twice
          walk.see_any(g);
          walk.see_any(g);
          break;
        case 4:
          if (!walk.poses().empty()) {
            const auto far = g.add(Point(Point::Constant(walk.rng().uniform(-300.0, 300.0))));
            Point near = Point::Zero();
            near.x() = 2.0;
            if (walk.rng().below(2) == 0) {
              TypeParam::see(g, walk.poses().back(), far,
                             {g.model.size() > 1 && TypeParam::kScaled ? 1 : -1}, near);
            }
          }
          break;
        case 5: {
          if (walk.poses().empty()) break;
          const auto bad = g.tested.add(Point(kNan * Point::Ones()));
          EXPECT_FALSE(bad);
          const VariableId<typename TypeParam::Pose> nobody{g.model.size()};
          if constexpr (!TypeParam::kScaled) {
            EXPECT_FALSE(g.tested.add(Between<SE2d>{}, walk.poses().back(), nobody));
          }
          break;
        }
        case 6:
          g.tested.discard_pending();
          g.model = solved;
          walk.forget(solved.size());
          break;
        case 7: {  // as a whole graph
          IncrementalGraphOptimiser<Graph> other;
          ASSERT_TRUE(other.append(g.model));
          ASSERT_TRUE(same(other.graph(), g.model));
          ASSERT_TRUE(g.tested.append(g.model));
          break;
        }
        default: {
          const auto expected = whole_step(g.model);
          const bool exact = walk.rng().below(2) == 0;
          const auto report = g.tested.update(exact ? kStep : kIncrementalDefaults<Graph>);
          if (!report) {
            ++refusals;
            ASSERT_FALSE(expected) << report.error().message;
            if (exact) {
              ASSERT_EQ(report.error().code, expected.error().code);
            }
            break;
          }
          ++updates;
          ASSERT_TRUE(expected) << expected.error().message;
          ASSERT_TRUE(std::isfinite(report->cost));
          if (exact && !report->fell_back) {
            ASSERT_LT(apart(g.tested.graph(), *expected), 1e-6);
          }
          g.model.set_values(g.tested.graph().values());
          ASSERT_NEAR(report->cost, cost_of(g.model), 1e-9 * (1.0 + report->cost));
          solved = g.model;
        }
      }
      ASSERT_TRUE(same(g.tested.graph(), g.model)) << k;
      ASSERT_FALSE(this->HasFailure()) << k;
    }
  }
  EXPECT_GT(updates, 100);
  EXPECT_GT(refusals, 10);
}

}  // namespace
}  // namespace wayfare
