#include <wayfare/graph/factor_graph.hpp>

#include <gtest/gtest.h>

#include <Eigen/Cholesky>

#include <wayfare/core/random.hpp>
#include <wayfare/graph/edges.hpp>
#include <wayfare/graph/eigen_solver.hpp>
#include <wayfare/graph/optimise.hpp>

#include "factor_worlds.hpp"

namespace wayfare {
namespace {

/// A scale of the odometry's length: three variables of three types, Jacobians by dual numbers.
struct ScaledStep {
  using Variables = EdgeVariables<SE2d, SE2d, Eigen::Matrix<double, 1, 1>>;
  using Jacobians = AutomaticJacobians;
  static constexpr int kDim = 3;
  Eigen::Vector3d step;
  double sigma = 0.05;

  template <class T>
  Eigen::Matrix<T, 3, 1> error(const SE2<T>& from, const SE2<T>& to,
                               const Eigen::Matrix<T, 1, 1>& scale) const {
    const SE2<T> d = from.inverse() * to;
    return Eigen::Matrix<T, 3, 1>(d.x() - scale[0] * T(step[0]), d.y() - scale[0] * T(step[1]),
                                  d.heading().radians() - T(step[2])) /
           T(sigma);
  }
};

/// Without Jacobians: differences.
struct Sighting {
  using Variables = EdgeVariables<SE2d, Eigen::Vector2d>;
  static constexpr int kDim = 2;
  Eigen::Vector2d seen;
  Eigen::Vector2d error(const SE2d& x, const Eigen::Vector2d& l) const {
    return (x.inverse() * l - seen) / 0.1;
  }
};

using tests::cost_of;
using Scale = tests::Scalar;
using Graph = FactorGraph<Variables<SE2d, Eigen::Vector2d, Scale>,
                          Edges<Between<SE2d>, ScaledStep, Sighting, Robust<BearingRange>,
                                RangeTo<SE2d>, Prior<SE2d>, Prior<Scale>>>;

struct Drive {
  Graph graph;
  std::vector<VariableId<SE2d>> poses;
  std::vector<VariableId<Eigen::Vector2d>> trees;
  VariableId<Scale> scale;
  std::vector<SE2d> truth;
  std::vector<Eigen::Vector2d> tree_truth;
};

/// A robot whose wheels count 5 % too much, on a circle among trees; `noise` scales all errors.
Drive drive(int steps, double noise, std::uint64_t seed) {
  Rng rng(seed);
  const auto vector = [&](double sigma) {
    return Eigen::Vector2d(noise * sigma * rng.normal(), noise * sigma * rng.normal());
  };
  Drive d;
  d.scale = d.graph.add(Scale(1.0));
  d.truth = {SE2d()};
  d.poses = {d.graph.add(SE2d())};
  d.graph.add(Prior<SE2d>{SE2d(), 1e6 * Eigen::Matrix3d::Identity()}, d.poses[0]);
  for (int t = 0; t < 6; ++t) {
    d.tree_truth.emplace_back(6.0 * std::cos(t), 5.0 + 6.0 * std::sin(t));
    d.trees.push_back(d.graph.add(Eigen::Vector2d(d.tree_truth.back() + vector(0.5))));
  }
  for (int i = 1; i <= steps; ++i) {
    const SE2d motion(1.0, 0.0, Angle::radians(0.2));
    d.truth.push_back(d.truth.back() * motion);
    const Eigen::Vector3d measured(motion.x() / 0.95, noise * 0.05 * rng.normal(),
                                   0.2 + noise * 0.01 * rng.normal());
    d.poses.push_back(d.graph.add(d.graph[d.poses.back()] * motion *
                                  SE2d(noise * 0.1, 0.0, Angle::radians(noise * 0.02))));
    d.graph.add(ScaledStep{measured}, d.poses[d.poses.size() - 2], d.poses.back(), d.scale);
    for (std::size_t t = 0; t < d.trees.size(); ++t) {
      const Eigen::Vector2d seen = d.truth.back().inverse() * d.tree_truth[t];
      if (t % 3 == 0)
        d.graph.add(Sighting{seen + vector(0.1)}, d.poses.back(), d.trees[t]);
      else if (t % 3 == 1)
        d.graph.add(Robust{BearingRange{Angle::radians(std::atan2(seen.y(), seen.x()) +
                                                       noise * 0.02 * rng.normal()),
                                        seen.norm(), Eigen::Vector2d(2500, 100).asDiagonal()},
                           RobustKernel{RobustKernelKind::huber, 2.0}},
                    d.poses.back(), d.trees[t]);
      else
        d.graph.add(RangeTo<SE2d>{seen.norm() + noise * 0.1 * rng.normal(),
                                  100.0 * Eigen::Matrix<double, 1, 1>::Identity()},
                    d.poses.back(), d.trees[t]);
    }
  }
  return d;
}

/// Offsets of the variables in a dense vector of all their numbers.
std::vector<int> offsets(const Graph& graph) {
  std::vector<int> first{0};
  for (int i = 0; i < graph.size(); ++i) first.push_back(first.back() + graph.dof(i));
  return first;
}

TEST(FactorGraph, FindsTheTruthOfExactMeasurements) {
  Drive d = drive(40, 0.0, 1);
  const auto report = optimise(d.graph);
  ASSERT_TRUE(report) << report.error().to_string();
  EXPECT_LT(report->final_cost, 1e-12);
  EXPECT_NEAR(d.graph[d.scale][0], 0.95, 1e-8);
  for (std::size_t i = 0; i < d.poses.size(); ++i)
    EXPECT_LT(d.graph[d.poses[i]].minus(d.truth[i]).norm(), 1e-7) << i;
}

// H and g are those of a dense sum over the edges, by differences of the cost.
TEST(FactorGraph, TheGradientIsThatOfTheCost) {
  Drive d = drive(8, 1.0, 2);
  FactorEquations<Graph> equations;
  equations.set_structure(d.graph);
  EXPECT_NEAR(equations.linearise(d.graph), cost_of(d.graph), 1e-9 * cost_of(d.graph));
  for (int v = 0; v < d.graph.size(); ++v) {
    for (int k = 0; k < d.graph.dof(v); ++k) {
      constexpr double kStep = 1e-6;
      Eigen::Vector3d step = Eigen::Vector3d::Zero();
      Graph ahead = d.graph, behind = d.graph;
      step[k] = kStep;
      ahead.move(v, step);
      behind.move(v, Eigen::Vector3d(-step));
      const double slope = (cost_of(ahead) - cost_of(behind)) / (2.0 * kStep);
      // The cost has no factor of ½.
      EXPECT_NEAR(2.0 * equations.gradient()[3 * equations.column(v) + k], slope,
                  1e-4 * (1.0 + std::abs(slope)))
          << v << ' ' << k;
    }
  }
}

// At the minimum no small step lowers the cost, with every solver and method.
TEST(FactorGraph, EndsAtAMinimum) {
  for (const std::uint64_t seed : {3U, 4U, 5U}) {
    Drive d = drive(30, 1.0, seed);
    Graph other = d.graph, damped = d.graph;
    OptimiseOptions options;
    options.min_relative_gain = 1e-12;
    ASSERT_TRUE(optimise(d.graph, options));
    ASSERT_TRUE((GraphOptimiser<Graph, EigenSolver<3>>().optimise(other, options)));
    options.method = OptimiseMethod::levenberg_marquardt;
    ASSERT_TRUE(optimise(damped, options));
    const double least = cost_of(d.graph);
    EXPECT_NEAR(cost_of(other), least, 1e-9 * least);
    EXPECT_NEAR(cost_of(damped), least, 1e-6 * least);
    for (int v = 0; v < d.graph.size(); ++v)
      for (int k = 0; k < d.graph.dof(v); ++k)
        for (const double size : {-1e-3, 1e-3}) {
          Graph moved = d.graph;
          moved.move(v, Eigen::Vector3d(size * Eigen::Vector3d::Unit(k)));
          EXPECT_GE(cost_of(moved), least * (1.0 - 1e-12)) << v << ' ' << k;
        }
  }
}

// Covariances are the blocks of the inverse of the dense H without unused rows.
TEST(FactorGraph, CovariancesAreThoseOfTheDenseInverse) {
  Drive d = drive(12, 1.0, 6);
  d.graph.fix(d.trees[0]);
  GraphOptimiser<Graph> optimiser;
  ASSERT_TRUE(optimiser.prepare_covariances(d.graph));
  FactorEquations<Graph> equations;
  equations.set_structure(d.graph);
  equations.linearise(d.graph);
  const std::vector<int> first = offsets(d.graph);
  Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(first.back(), first.back());
  const auto& h = equations.hessian();
  for (int c = 0; c < h.columns(); ++c)
    for (int i = h.starts()[std::size_t(c)]; i < h.starts()[std::size_t(c) + 1]; ++i) {
      const int a = equations.free()[std::size_t(h.rows()[std::size_t(i)])];
      const int b = equations.free()[std::size_t(c)];
      const auto block = h.block(i).topLeftCorner(d.graph.dof(a), d.graph.dof(b));
      dense.block(first[std::size_t(a)], first[std::size_t(b)], block.rows(), block.cols()) = block;
      dense.block(first[std::size_t(b)], first[std::size_t(a)], block.cols(), block.rows()) =
          block.transpose();
    }
  for (int k = 0; k < 2; ++k)  // the fixed tree
    dense(first[std::size_t(d.trees[0].index)] + k, first[std::size_t(d.trees[0].index)] + k) = 1.0;
  const Eigen::MatrixXd inverse =
      dense.llt().solve(Eigen::MatrixXd::Identity(dense.rows(), dense.rows()));
  const auto block = [&](int v) {
    return inverse.block(first[std::size_t(v)], first[std::size_t(v)], d.graph.dof(v),
                         d.graph.dof(v));
  };
  EXPECT_TRUE(optimiser.covariance(d.poses.back()).isApprox(block(d.poses.back().index), 1e-8));
  EXPECT_TRUE(optimiser.covariance(d.trees[3]).isApprox(block(d.trees[3].index), 1e-8));
  EXPECT_TRUE(optimiser.covariance(d.scale).isApprox(block(d.scale.index), 1e-8));
  EXPECT_TRUE(optimiser.covariance(d.trees[0]).isZero(0.0)) << "fixed";
  const auto all = optimiser.covariances(d.graph);
  ASSERT_TRUE(all);
  EXPECT_TRUE((*all)[std::size_t(d.trees[3].index)].topLeftCorner(2, 2).isApprox(
      block(d.trees[3].index), 1e-8));
}

// A factor graph of poses and relative poses has the optimum of the pose graph.
TEST(FactorGraph, OfPosesOnlyEqualsThePoseGraph) {
  Rng rng(7);
  PoseGraph2 poses;
  FactorGraph<Variables<SE2d>, Edges<Between<SE2d>>> factors;
  std::vector<VariableId<SE2d>> ids;
  for (int i = 0; i < 30; ++i) {
    const SE2d x(i + 0.1 * rng.normal(), 0.1 * rng.normal(), Angle::radians(0.1 * rng.normal()));
    poses.add_pose(x);
    ids.push_back(factors.add(x));
  }
  factors.fix(ids[0]);
  for (int i = 1; i < 30; ++i)
    for (const int back : {1, 7}) {
      if (i < back) continue;
      const SE2d z(back + 0.02 * rng.normal(), 0.02 * rng.normal(),
                   Angle::radians(0.01 * rng.normal()));
      const Eigen::Matrix3d information = Eigen::Vector3d(2500, 2500, 1e4).asDiagonal();
      poses.edges.push_back({i - back, i, z, information});
      factors.add(Between<SE2d>{z, information}, ids[std::size_t(i - back)], ids[std::size_t(i)]);
    }
  const auto one = optimise(poses), two = optimise(factors);
  ASSERT_TRUE(one && two);
  EXPECT_NEAR(one->final_cost, two->final_cost, 1e-9 * one->final_cost);
  for (std::size_t i = 0; i < 30; ++i)
    EXPECT_LT(factors[ids[i]].minus(poses.poses[i]).norm(), 1e-7);
}

// The undetermined variable and direction are named, and nothing has moved.
TEST(FactorGraph, NamesWhatIsNotDetermined) {
  FactorGraph<Variables<SE2d, Eigen::Vector2d>, Edges<RangeTo<SE2d>, Prior<SE2d>>> graph;
  const auto pose = graph.add(SE2d());
  const auto beacon = graph.add(Eigen::Vector2d(3.0, 0.0));
  graph.add(Prior<SE2d>{SE2d()}, pose);
  graph.add(RangeTo<SE2d>{2.0}, pose, beacon);
  GraphOptimiser<decltype(graph)> optimiser;
  const auto done = optimiser.optimise(graph);
  ASSERT_FALSE(done);
  EXPECT_EQ(done.error().code, ErrorCode::degenerate);
  EXPECT_EQ(optimiser.undetermined().variable, beacon.index) << done.error().message;
  EXPECT_NEAR(std::abs(optimiser.undetermined().direction[1]), 1.0, 1e-6) << "across the range";
  EXPECT_EQ(graph[beacon], Eigen::Vector2d(3.0, 0.0));
}

TEST(FactorGraph, NamesTheEdgeWhoseErrorIsNotFinite) {
  Drive d = drive(3, 0.0, 8);
  d.graph.add(Sighting{Eigen::Vector2d(NAN, 0.0)}, d.poses[2], d.trees[1]);
  const Graph before = d.graph;
  auto done = optimise(d.graph);
  ASSERT_FALSE(done);
  EXPECT_NE(done.error().message.find("(9, 3) has an error that is not finite"), std::string::npos)
      << done.error().message;
  EXPECT_EQ(d.graph[d.trees[1]], before[d.trees[1]]);
  Drive far = drive(3, 0.0, 8);
  far.graph.add(Sighting{Eigen::Vector2d(1e200, 0.0)}, far.poses[2], far.trees[1]);
  done = optimise(far.graph);
  ASSERT_FALSE(done);
  EXPECT_NE(done.error().message.find("too large to square"), std::string::npos);
  Drive bad = drive(3, 0.0, 8);
  bad.graph.add(Prior<SE2d>{SE2d(), -Eigen::Matrix3d::Identity()}, bad.poses[1]);
  done = optimise(bad.graph);
  ASSERT_FALSE(done);
  EXPECT_NE(done.error().message.find("not positive semi-definite"), std::string::npos);
  Graph empty;
  EXPECT_FALSE(optimise(empty));
}

TEST(FactorGraph, RefusesVariablesOfAnotherGraph) {
  Drive d = drive(3, 0.0, 9);
  EXPECT_DEATH(d.graph.fix(VariableId<SE2d>{1000}), "one of its graph");
  EXPECT_DEATH(d.graph.fix(VariableId<SE2d>{d.trees[0].index}), "one of its graph");
  EXPECT_DEATH(d.graph.add(Prior<SE2d>{SE2d()}, VariableId<SE2d>{}), "variables of its graph");
}

struct Difference {
  using Variables = EdgeVariables<Scale, Scale>;
  static constexpr int kDim = 1;
  Scale error(const Scale& a, const Scale& b) const { return a + 2.0 * b - Scale(6.0); }
};

// An edge may join a variable to itself: its Jacobians add.
TEST(FactorGraph, AnEdgeMayNameAVariableTwice) {
  FactorGraph<Variables<Scale>, Edges<Difference>> graph;
  const auto x = graph.add(Scale(0.0));
  graph.add(Difference{}, x, x);
  ASSERT_TRUE(optimise(graph));
  EXPECT_NEAR(graph[x][0], 2.0, 1e-9);
}

struct SumOfThree {
  using Variables = EdgeVariables<Scale, Scale, Scale>;
  static constexpr int kDim = 1;
  Scale error(const Scale& a, const Scale& b, const Scale& c) const {
    return a + b + c - Scale(6.0);
  }
};

// The same variables in the same order, in pairs and in threes: another structure.
TEST(FactorGraph, AnOptimiserTakesAGraphWithEdgesOfAnotherArityNext) {
  using Mixed = FactorGraph<Variables<Scale>, Edges<Prior<Scale>, Difference, SumOfThree>>;
  Mixed pairs;
  std::vector<VariableId<Scale>> x;
  for (int i = 0; i < 6; ++i) x.push_back(pairs.add(Scale(0.1 * i)));
  for (const auto& v : x) pairs.add(Prior<Scale>{Scale(1.0)}, v);
  Mixed threes = pairs;
  for (const int i : {0, 2, 4})
    pairs.add(Difference{}, x[static_cast<std::size_t>(i)], x[static_cast<std::size_t>(i) + 1]);
  threes.add(SumOfThree{}, x[0], x[1], x[2]);
  threes.add(SumOfThree{}, x[3], x[4], x[5]);
  GraphOptimiser<Mixed> optimiser;
  ASSERT_TRUE(optimiser.optimise(pairs));
  ASSERT_TRUE(optimiser.optimise(threes));
  ASSERT_TRUE(optimiser.optimise(pairs));
  for (std::size_t i = 0; i < 6; ++i) {
    // In threes x − 1 = 6 − 3x. In pairs, with λ = 6 − a − 2b: a = 1 + λ and
    // b = 1 + 2λ, so that 6λ = 3.
    EXPECT_NEAR(threes[x[i]][0], 1.75, 1e-9) << i;
    EXPECT_NEAR(pairs[x[i]][0], i % 2 == 0 ? 1.5 : 2.0, 1e-9) << i;
  }
}

}  // namespace
}  // namespace wayfare
