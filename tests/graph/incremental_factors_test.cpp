// The incremental optimiser on factor graphs, beside the batch optimiser.

#include <wayfare/graph/incremental.hpp>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include <Eigen/Cholesky>

#include <wayfare/graph/optimise.hpp>

#include "factor_worlds.hpp"

namespace wayfare {
namespace {

using tests::apart;
using tests::Both;
using tests::cost_of;
using tests::same;
using tests::Scalar;
using tests::Walk;

constexpr IncrementalOptions kStep{.relinearise_step = 0.0, .solve_change = 0.0, .max_rounds = 1};
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

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
          const auto report = g.tested.update(exact ? kStep : IncrementalOptions{});
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

/// c₀x + c₁y + c₂z − b, of three variables that may be the same.
struct Linear {
  using Variables = EdgeVariables<Scalar, Scalar, Scalar>;
  static constexpr int kDim = 1;
  Eigen::Vector3d c;
  double b;
  Scalar error(const Scalar& x, const Scalar& y, const Scalar& z) const {
    return Scalar(c[0] * x[0] + c[1] * y[0] + c[2] * z[0] - b);
  }
  Scalar linearise(const Scalar& x, const Scalar& y, const Scalar& z,
                   EdgeJacobians<1, Variables>& j) const {
    std::get<0>(j.by) = Scalar(c[0]);
    std::get<1>(j.by) = Scalar(c[1]);
    std::get<2>(j.by) = Scalar(c[2]);
    return error(x, y, z);
  }
};
using LinearGraph = FactorGraph<Variables<Scalar>, Edges<Linear, Prior<Scalar>>>;

// Linear least squares in dense algebra: edges may name a variable twice or three times, or fixed
// ones only.
TEST(IncrementalFactorGraph, OfLinearEdgesFollowsDenseLeastSquares) {
  Rng rng(31);
  for (int run = 0; run < 20; ++run) {
    IncrementalGraphOptimiser<LinearGraph> growing;
    std::vector<VariableId<Scalar>> x;
    std::vector<Eigen::VectorXd> rows;
    std::vector<double> right;
    const double held = rng.normal();
    for (int step = 0; step < 60; ++step) {
      const auto added = growing.add(Scalar(x.empty() ? held : 0.0), x.empty());
      ASSERT_TRUE(added);
      x.push_back(*added);
      const auto row = [&](double b) {
        rows.push_back(Eigen::VectorXd::Zero(60));
        right.push_back(b);
        return rows.size() - 1;
      };
      if (x.size() > 1) {
        ASSERT_TRUE(growing.add(Prior<Scalar>{Scalar(0.5)}, x.back()));
        rows[row(0.5)][x.back().index] = 1.0;
      }
      for (int n = 0; n < 2; ++n) {
        Linear edge{Eigen::Vector3d(rng.normal(), rng.normal(), rng.normal()), rng.normal()};
        std::array<VariableId<Scalar>, 3> ends;
        const std::size_t few = rng.below(3) == 0 ? std::min<std::size_t>(2, x.size()) : x.size();
        for (auto& end : ends) end = x[x.size() - 1 - rng.below(few)];
        ASSERT_TRUE(growing.add(edge, ends[0], ends[1], ends[2]));
        const std::size_t at = row(edge.b);
        for (int i = 0; i < 3; ++i) rows[at][ends[std::size_t(i)].index] += edge.c[i];
      }
      ASSERT_TRUE(growing.update(kStep));
      const auto n = static_cast<Eigen::Index>(x.size()) - 1;
      if (n == 0) continue;
      Eigen::MatrixXd a(rows.size(), n);
      Eigen::VectorXd b(rows.size());
      for (std::size_t i = 0; i < rows.size(); ++i) {
        a.row(Eigen::Index(i)) = rows[i].segment(1, n).transpose();
        b[Eigen::Index(i)] = right[i] - held * rows[i][0];
      }
      const Eigen::VectorXd expected = (a.transpose() * a).llt().solve(a.transpose() * b);
      for (Eigen::Index i = 0; i < n; ++i)
        ASSERT_NEAR(growing[x[std::size_t(i) + 1]][0], expected[i], 1e-8) << step << ' ' << i;
    }
  }
}

/// Not a number once `left` evaluations are used up.
struct Fuse {
  using Variables = EdgeVariables<Scalar>;
  static constexpr int kDim = 1;
  long* left;
  Scalar error(const Scalar& x) const { return Scalar(--*left >= 0 ? x[0] - 3.0 : kNan); }
};

// Wherever the user's error function stops giving numbers, the update is refused and nothing has
// changed; once it gives them again the same update succeeds.
TEST(IncrementalFactorGraph, SurvivesErrorsThatAreNotNumbers) {
  using Graph = FactorGraph<Variables<Scalar>, Edges<Prior<Scalar>, Fuse>>;
  int refused = 0, at_once = 0;
  for (long fuse = 0; fuse < 60; ++fuse) {
    long left = 1000;
    IncrementalGraphOptimiser<Graph> growing;
    const auto x = growing.add(Scalar(1.0)), y = growing.add(Scalar(2.0));
    ASSERT_TRUE(growing.add(Prior<Scalar>{Scalar(0.0)}, *x));
    ASSERT_TRUE(growing.add(Prior<Scalar>{Scalar(1.0)}, *y));
    ASSERT_TRUE(growing.add(Fuse{&left}, *y));
    ASSERT_TRUE(growing.update(kStep));
    ASSERT_TRUE(growing.add(Fuse{&left}, *x));
    const Graph before = growing.graph();
    left = fuse;
    const auto report = growing.update({.relinearise_step = 0.0, .solve_change = 0.0});
    if (!report) {
      ++refused;
      EXPECT_NE(report.error().message.find("not finite"), std::string::npos)
          << report.error().message;
      ASSERT_TRUE(same(growing.graph(), before)) << fuse;
      left = 1000;
      if (fuse % 2 == 0) {
        growing.discard_pending();
        EXPECT_EQ(growing.graph().edge_count(), 3);
        ASSERT_TRUE(growing.add(Fuse{&left}, *x));
      }
    } else {
      ++at_once;
    }
    left = 1000;
    ASSERT_TRUE(growing.update(kStep));
    // Both are the mean of two measurements: (0 + 3)/2, (1 + 3)/2.
    EXPECT_NEAR(growing[*x][0], 1.5, 1e-8) << fuse;
    EXPECT_NEAR(growing[*y][0], 2.0, 1e-8) << fuse;
  }
  EXPECT_GT(refused, 3);
  EXPECT_GT(at_once, 3);
}

TEST(IncrementalFactorGraph, RefusesBadAdditionsByNameAndKeepsTheRest) {
  using Graph = tests::ScaledWheels::Graph;
  Walk<tests::ScaledWheels> walk(41);
  Both<Graph> g;
  for (int i = 0; i < 6; ++i) walk.grow(g), walk.see_any(g);
  ASSERT_TRUE(g.tested.update(kStep));
  const Graph before = g.tested.graph();
  const auto pose = walk.poses()[2];
  const auto refuses = [&](const Result<void>& added, const std::string& message) {
    ASSERT_FALSE(added) << message;
    EXPECT_NE(added.error().message.find(message), std::string::npos) << added.error().message;
    EXPECT_TRUE(same(g.tested.graph(), before));
  };
  VariableId<Eigen::Vector2d> point;
  for (const auto& each : walk.points())
    if (each.index >= 0) point = each;
  refuses(g.tested.add(tests::Sighting{{1, 1}}, pose, VariableId<Eigen::Vector2d>{999}),
          "names variable 999, which the graph does not have");
  refuses(g.tested.add(tests::Sighting{{1, 1}}, pose, VariableId<Eigen::Vector2d>{pose.index}),
          "which the graph does not have");
  refuses(g.tested.add(tests::Sighting{{kNan, 1}}, pose, point), "error that is not finite");
  refuses(g.tested.add(tests::Sighting{{1e200, 1}}, pose, point), "too large to square");
  refuses(g.tested.add(RangeTo<SE2d>{1.0, -Scalar::Identity()}, pose, point),
          "not positive semi-definite");
  refuses(g.tested.add(RangeTo<SE2d>{1.0, Scalar::Zero()}, pose, point), "has zero information");
  refuses(g.tested.fix(pose), "was free and is fixed now");
  refuses(g.tested.fix(VariableId<SE2d>{-3}), "is not in the graph");
  ASSERT_FALSE(g.tested.add(SE2d(kNan, 0.0, Angle::radians(0.0))));
  EXPECT_TRUE(g.tested.update(kStep));
}

// A range alone leaves the direction across it open: named as by the batch optimiser, and solved
// once a second range comes.
TEST(IncrementalFactorGraph, NamesWhatIsNotDeterminedAndWaitsForTheRest) {
  using Graph = FactorGraph<Variables<SE2d, Eigen::Vector2d>, Edges<RangeTo<SE2d>>>;
  IncrementalGraphOptimiser<Graph> growing;
  ASSERT_FALSE(growing.update());
  const auto left = growing.add(SE2d(), true),
             right = growing.add(SE2d(4.0, 0.0, Angle::radians(1.0)), true);
  ASSERT_TRUE(growing.update());
  const auto beacon = growing.add(Eigen::Vector2d(3.0, 0.0));
  ASSERT_TRUE(growing.add(RangeTo<SE2d>{2.0}, *left, *beacon));
  for (int again = 0; again < 2; ++again) {
    Graph batch = growing.graph();
    const auto expected = optimise(batch);
    const auto refused = growing.update(kStep);
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().message, expected.error().message);
    EXPECT_EQ(growing.undetermined().variable, beacon->index);
    EXPECT_NEAR(std::abs(growing.undetermined().direction[1]), 1.0, 1e-6) << "across the range";
    EXPECT_EQ(growing[*beacon], Eigen::Vector2d(3.0, 0.0));
    ASSERT_FALSE(growing.optimise_fully());
  }
  growing.discard_pending();
  EXPECT_EQ(growing.graph().size(), 2);
  const auto above = growing.add(Eigen::Vector2d(2.0, 1.0));
  // 3-4-5 triangles on both sides of x = 2, height 1.5.
  ASSERT_TRUE(growing.add(RangeTo<SE2d>{2.5}, *left, *above));
  ASSERT_TRUE(growing.add(RangeTo<SE2d>{2.5}, *right, *above));
  ASSERT_TRUE(growing.update({.relinearise_step = 0.0, .solve_change = 0.0, .max_rounds = 20}));
  EXPECT_LT((growing[*above] - Eigen::Vector2d(2.0, 1.5)).norm(), 1e-9);
}

}  // namespace
}  // namespace wayfare
