// The incremental optimiser on factor graphs: dense oracles, faults and refusals.

#include <wayfare/graph/growing_factor_graph.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include <Eigen/Cholesky>

#include <wayfare/graph/incremental.hpp>
#include <wayfare/graph/optimise.hpp>

#include "factor_worlds.hpp"

namespace wayfare {
namespace {

using tests::Both;
using tests::kNan;
using tests::kStep;
using tests::same;
using tests::Scalar;
using tests::Walk;

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

/// Not a number below zero.
struct Root {
  using Variables = EdgeVariables<Scalar>;
  using Jacobians = AutomaticJacobians;
  static constexpr int kDim = 1;
  template <class T>
  Eigen::Matrix<T, 1, 1> error(const Eigen::Matrix<T, 1, 1>& x) const {
    using std::sqrt;
    return Eigen::Matrix<T, 1, 1>(sqrt(x[0]) - T(1.0));
  }
};

// An edge that is a number where its variable is, though not where it was linearised last.
TEST(IncrementalFactorGraph, LinearisesAtTheValuesWhereOldPointsWillNotDo) {
  using Graph = FactorGraph<Variables<Scalar>, Edges<Prior<Scalar>, Root>>;
  IncrementalGraphOptimiser<Graph> growing;
  const auto x = growing.add(Scalar(-1.0));
  ASSERT_TRUE(growing.add(Prior<Scalar>{Scalar(4.0)}, *x));
  ASSERT_FALSE(growing.add(Root{}, *x)) << "at -1";
  ASSERT_TRUE(growing.update({.relinearise_step = 100.0}));
  EXPECT_NEAR(growing[*x][0], 4.0, 1e-9);
  ASSERT_TRUE(growing.add(Root{}, *x));
  const auto report = growing.update({.relinearise_step = 100.0, .max_rounds = 1});
  ASSERT_TRUE(report) << report.error().message;
  // At 4 the root's error is 1 and its slope 1/4: (1 + 1/16) d = -1/4.
  EXPECT_NEAR(growing[*x][0], 4.0 - 0.25 / 1.0625, 1e-9);
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
