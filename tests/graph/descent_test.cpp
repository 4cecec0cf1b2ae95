#include <wayfare/graph/detail/descent.hpp>

#include <cmath>
#include <set>
#include <string>

#include <gtest/gtest.h>

#include <wayfare/graph/detail/damped_step.hpp>
#include <wayfare/graph/linear_solver.hpp>
#include <wayfare/graph/report.hpp>

#include "tangle.hpp"

namespace wayfare {
namespace {

TEST(OptimiseControl, StopsIfTheGainIsSmallOrTheCallbackSaysSo) {
  OptimiseReport report;
  OptimiseOptions options{.min_relative_gain = 1e-2, .min_absolute_gain = 0.5};
  OptimiseControl control(options, report);
  EXPECT_FALSE(control.taken(100.0, {90.0, 0.0, 1.0, true}));
  EXPECT_TRUE(control.taken(100.0, {99.5, 0.0, 1.0, true}));  // gains less than a hundredth
  EXPECT_EQ(report.reason, StopReason::converged);
  EXPECT_TRUE(control.taken(1.0, {0.6, 0.0, 1.0, true}));  // gains less than a half
  report.final_cost = 0.6;
  EXPECT_FALSE(control.refused(7.0));
  ASSERT_EQ(report.history.size(), 4U);
  EXPECT_EQ(report.history.back().cost, 0.6);
  EXPECT_EQ(report.history.back().damping, 7.0);
  EXPECT_FALSE(report.history.back().accepted);

  std::vector<int> numbers;
  options.progress = [&](int number, const IterationRecord&) {
    numbers.push_back(number);
    return false;
  };
  EXPECT_TRUE(control.taken(100.0, {1.0, 0.0, 1.0, true}));
  EXPECT_EQ(report.reason, StopReason::stopped);
  EXPECT_TRUE(control.refused(1.0));
  EXPECT_EQ(numbers, (std::vector<int>{5, 6}));
  report.iterations = options.max_iterations - 1;
  EXPECT_TRUE(control.may_iterate());
  ++report.iterations;
  EXPECT_FALSE(control.may_iterate());
}

TEST(StopReason, HasADistinctName) {
  std::set<std::string> names;
  for (const auto reason : {StopReason::converged, StopReason::max_iterations, StopReason::stopped,
                            StopReason::no_progress})
    names.emplace(to_string(reason));
  EXPECT_EQ(names.size(), 4U);
  EXPECT_FALSE(names.contains(""));
}

TEST(PhaseTimer, AddsToThePreviousValue) {
  double seconds = 1e6;
  { const PhaseTimer timer(seconds); }
  const double once = seconds;
  EXPECT_GE(once, 1e6);
  { const PhaseTimer timer(seconds); }
  EXPECT_GE(seconds, once);
}

using PlaneStep = DampedStep<PoseGraph2, MultifrontalCholesky<3>>;

struct Descent {
  PoseGraph2 graph;
  OptimiseOptions options;
  OptimiseReport report;
  PlaneStep step;

  explicit Descent(PoseGraph2 start, OptimiseOptions o = {})
      : graph(std::move(start)), options(std::move(o)) {
    step.prepare(graph);
    report.initial_cost = report.final_cost = step.linearise(graph, options.kernel);
  }
};

// With correct headings the problem is linear in x and y: one step solves it. Two edges to one
// pose, at 1 m and 2 m with weights 1 and 3: the minimum is at 1.75 m, with cost ¾.
TEST(GaussNewton, SolvesALinearProblemInOneStep) {
  PoseGraph2 graph{{SE2d(), SE2d(9.0, -4.0, Angle{})}, {}, {}, {}};
  graph.edges = {{0, 1, SE2d(1.0, 0.0, Angle{}), Eigen::Matrix3d::Identity(), false},
                 {0, 1, SE2d(2.0, 0.0, Angle{}), 3.0 * Eigen::Matrix3d::Identity(), false}};
  Descent d(graph);
  EXPECT_TRUE(gauss_newton(d.step, d.graph, d.options, d.report));
  EXPECT_EQ(d.report.reason, StopReason::converged);
  EXPECT_NEAR(d.graph.poses[1].x(), 1.75, 1e-12);
  EXPECT_NEAR(d.graph.poses[1].y(), 0.0, 1e-12);
  EXPECT_NEAR(d.report.final_cost, 0.75, 1e-12);
  EXPECT_LE(d.report.iterations, 2);
  EXPECT_NEAR(d.report.history.front().cost, 0.75, 1e-12);
}

// From any start, both methods end at no higher cost, every accepted step lowers the cost, and the
// reported cost is that of the final poses.
TEST(Descent, NeverRaisesTheCost) {
  int given_up = 0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    Rng rng(seed);
    auto graph = tests::tangle<SE2d>(rng);
    for (auto& pose : graph.poses) pose = pose.plus(tests::random_tangent<SE2d>(rng, 3.0));
    for (const bool damped : {false, true}) {
      Descent d(graph);
      if (damped) {
        ASSERT_TRUE(levenberg_marquardt(d.step, d.graph, d.options, d.report));
      } else {
        given_up += gauss_newton(d.step, d.graph, d.options, d.report) ? 0 : 1;
      }
      // Seven costs added up by two formulas: 7 · 2⁻⁵³ apart each, less than 1e-14 in all.
      double cost = d.report.initial_cost;
      for (const IterationRecord& record : d.report.history) {
        EXPECT_LE(record.cost, cost * (1.0 + 1e-14));
        cost = record.cost;
      }
      EXPECT_NEAR(d.report.final_cost, chi2(d.graph), 1e-9 * d.report.initial_cost);
      EXPECT_LE(d.report.final_cost, d.report.initial_cost);
      if (damped) {
        // At a minimum the gradient is negligible compared with the initial one.
        PlaneStep end;
        end.prepare(d.graph);
        end.linearise(d.graph, {});
        EXPECT_LT(end.equations().gradient().norm(), 1e-2 * std::sqrt(d.report.final_cost));
      }
    }
  }
  EXPECT_GT(given_up, 0);  // far from the optimum some full steps raise the cost
}

}  // namespace
}  // namespace wayfare
