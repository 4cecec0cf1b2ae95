// The parts below the optimiser: linear solvers, kernels, path uncertainties and replays.

#include <cmath>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include <wayfare/core/random.hpp>
#include <wayfare/graph/path_uncertainty.hpp>

#include <wayfare/testing/solver_laws.hpp>
#include "abuse/graph_cases.hpp"
#include "graph/solvers.hpp"

namespace wayfare::tests {
namespace {

using testing::dense;
using testing::expect_solves;
using testing::fill;
using testing::random_pairs;

template <class Solver>
class SolverAbuse : public ::testing::Test {};
TYPED_TEST_SUITE(SolverAbuse, AllSolvers);

TYPED_TEST(SolverAbuse, AMatrixWithoutColumnsIsSolved) {
  TypeParam solver;
  for (int again = 0; again < 2; ++again) {
    const BlockSparse<TypeParam::kBlock> none(0, {});
    solver.analyse(none);
    EXPECT_TRUE(solver.factorise(none).ok);
    Eigen::VectorXd x(0);
    solver.solve_in_place(x);
    Rng rng(3);
    BlockSparse<TypeParam::kBlock> some(5, random_pairs(rng, 5, 9));
    expect_solves(solver, some, rng);
  }
}

// The rule of FactorOutcome does not depend on the scale of H.
TYPED_TEST(SolverAbuse, AnyScaleIsSolved) {
  constexpr int kBlock = TypeParam::kBlock;
  Rng rng(6);
  BlockSparse<kBlock> h(7, random_pairs(rng, 7, 9));
  const Eigen::MatrixXd dense = fill(h, rng);
  const Eigen::VectorXd b = Eigen::VectorXd::LinSpaced(dense.rows(), -1.0, 2.0);
  const Eigen::VectorXd expected = dense.llt().solve(b);
  for (const int exponent : {-900, -500, 500, 900}) {
    BlockSparse<kBlock> scaled = h;
    for (int i = 0; i < h.blocks(); ++i) scaled.block(i) *= std::ldexp(1.0, exponent);
    TypeParam solver;
    solver.analyse(scaled);
    ASSERT_TRUE(solver.factorise(scaled).ok) << exponent;
    Eigen::VectorXd x = b;
    solver.solve_in_place(x);
    EXPECT_LT((x * std::ldexp(1.0, exponent) - expected).norm(), 1e-12) << exponent;
  }
}

TYPED_TEST(SolverAbuse, TwoThreadsDoNotDisturbEachOther) {
  const auto all = in_two_threads([](int) {
    Rng rng(8);
    Bits bits;
    TypeParam solver;
    for (const int columns : {1, 30, 300, 2}) {
      BlockSparse<TypeParam::kBlock> h(columns, random_pairs(rng, columns, 3 * columns));
      solver.analyse(h);
      fill(h, rng);
      EXPECT_TRUE(solver.factorise(h).ok);
      Eigen::VectorXd x = Eigen::VectorXd::Ones(columns * TypeParam::kBlock);
      solver.solve_in_place(x);
      add_bits(bits, x);
    }
    return bits;
  });
  EXPECT_EQ(all[0], all[1]);
}

TEST(MultifrontalCholeskyAbuse, MayBeMovedBetweenAllSteps) {
  Rng rng(9);
  BlockSparse<3> h(20, random_pairs(rng, 20, 40));
  const Eigen::MatrixXd inverse = fill(h, rng).inverse();
  expect_move_semantics(
      [&] {
        MultifrontalCholesky<3> solver;
        solver.analyse(h);
        EXPECT_TRUE(solver.factorise(h).ok);
        solver.invert();
        return solver;
      },
      [&](MultifrontalCholesky<3>& solver) {
        Bits bits;
        for (int c = 0; c < 20; ++c) {
          Eigen::Matrix3d block;
          EXPECT_TRUE(solver.inverse_block(c, c, block));
          EXPECT_LT((block - inverse.block<3, 3>(3 * c, 3 * c)).norm(), 1e-12);
          add_bits(bits, block);
        }
        EXPECT_TRUE(solver.factorise(h).ok);
        Eigen::Matrix3d block;
        EXPECT_FALSE(solver.inverse_block(0, 0, block)) << "not since this factorisation";
        return bits;
      });
  MultifrontalCholesky<3> solver;
  Eigen::Matrix3d block;
  EXPECT_FALSE(solver.inverse_block(0, 0, block)) << "before any factorisation";
}

TEST(BlockSparseAbuse, IsAValue) {
  Rng rng(10);
  BlockSparse<2> h(6, random_pairs(rng, 6, 12));
  fill(h, rng);
  expect_value_semantics(h, [](BlockSparse<2>& m) {
    Bits bits{static_cast<std::uint64_t>(m.columns())};
    add_bits(bits, dense(m));
    m.set_zero();
    return bits;
  });
  const std::vector<std::pair<int, int>> repeated(1000, {1, 0});
  EXPECT_EQ((BlockSparse<2>(2, repeated).blocks()), 3);
  EXPECT_EQ(BlockSparse<2>().columns(), 0);
}

TEST(RobustKernelAbuse, EveryScaleGivesACostBelowTheSquareAndAWeightUpToOne) {
  using enum RobustKernelKind;
  for (const auto kind : {none, huber, cauchy, geman_mcclure, dynamic_covariance_scaling}) {
    for (const double scale : {1e-70, 1e-9, 1.0, 1e9, 1e150, 1e200, kInf}) {
      for (const double s : {0.0, kTiny, 1.0, 1e9, 1e150}) {
        const KernelValue rho = RobustKernel{kind, scale}(s);
        EXPECT_TRUE(rho.cost >= 0.0 && rho.cost <= s * (1.0 + 1e-15)) << scale << ", " << s;
        EXPECT_TRUE(rho.weight >= 0.0 && rho.weight <= 1.0) << scale << ", " << s;
        if (scale >= 1e150 && s <= 1.0) {
          EXPECT_EQ(rho.weight, 1.0) << "a kernel that never applies";
          EXPECT_NEAR(rho.cost, s, 1e-15);
        }
      }
    }
  }
}

TEST(GncWeightAbuse, IsBetweenZeroAndOne) {
  for (const auto loss : {GncLoss::truncated_least_squares, GncLoss::geman_mcclure}) {
    for (const double mu : {kTiny, 1e-9, 1.0, 1e9, kHuge}) {
      double last = 1.0;
      for (const double u : {0.0, kTiny, 1e-9, 0.5, 1.0, 2.0, 1e9, kHuge, kInf}) {
        const double weight = gnc_weight(loss, u, mu);
        EXPECT_TRUE(weight >= 0.0 && weight <= last) << u << ", " << mu << ": " << weight;
        last = weight;
      }
    }
  }
}

PoseGraph2 ring(int poses, double radius_m) {
  PoseGraph2 graph;
  for (int i = 0; i < poses; ++i) {
    const Angle turn = Angle::radians(i * 6.0 / poses);
    graph.add_pose(
        SE2d(radius_m * std::cos(turn.radians()), radius_m * std::sin(turn.radians()), turn));
    if (i > 0) graph.edges.push_back({i - 1, i, SE2d(), Eigen::Matrix3d::Identity()});
  }
  return graph;
}
constexpr auto kAnyEdge = [](const PoseEdge<SE2d>&) { return true; };

// An edge whose information has no inverse, or none that is a covariance, leads nowhere: with
// negative variances a search would become shorter on every round of a loop, without end.
TEST(PathUncertaintyAbuse, EdgesWithoutACovarianceAreNotUsed) {
  const Eigen::Vector3d v(0.3, 1.0, -0.7);
  const Eigen::Matrix3d one = Eigen::Matrix3d::Identity(), axis = v * v.transpose();
  for (const Eigen::Matrix3d& bad :
       {Eigen::Matrix3d(0.0 * one), axis, Eigen::Matrix3d(axis - 1e-13 * one),
        Eigen::Matrix3d(-one), Eigen::Matrix3d(kNan * one), Eigen::Matrix3d(-kInf * one),
        Eigen::Matrix3d(kTiny * 1e-20 * one)}) {
    auto graph = ring(20, 5.0);
    for (const int to : {5, 9, 14}) graph.edges.push_back({2, to, SE2d(), bad});
    graph.edges[11].information = bad;  // from pose 11 to 12
    const auto found = path_uncertainty(graph, 0, kAnyEdge);
    const auto expected = path_uncertainty(ring(20, 5.0), 0, kAnyEdge);
    for (int k = 0; k < 20; ++k) {
      const double size = found.size[static_cast<std::size_t>(k)];
      if (k < 12) {
        EXPECT_EQ(size, expected.size[static_cast<std::size_t>(k)]) << bad;
      } else {
        EXPECT_GT(size, 1e9) << bad;  // a rank that is lost to rounding may leave a huge variance
      }
    }
  }
}

TEST(PathUncertaintyAbuse, OnePoseNoEdgesTwoThreadsAndItsLife) {
  EXPECT_TRUE(path_uncertainty(ring(1, 1.0), 0, kAnyEdge).reached(0));
  const auto none = path_uncertainty(ring(9, 1.0), 4, [](const PoseEdge<SE2d>&) { return false; });
  for (int k = 0; k < 9; ++k) EXPECT_EQ(none.reached(k), k == 4);
  const auto probe = [](PathUncertaintyFinder& finder) {
    return finder.find(ring(40, 3.0), 7, kAnyEdge).size;
  };
  PathUncertaintyFinder used;
  (void)used.find(ring(20, 3.0), 3, kAnyEdge);
  expect_value_semantics(used, probe);
  const auto both = in_two_threads([&](int) {
    PathUncertaintyFinder finder;
    return probe(finder);
  });
  EXPECT_EQ(both[0], both[1]);
}

TEST(ReplayAbuse, EveryEdgeOnceAndEveryReachablePoseOnce) {
  EXPECT_TRUE(replay_steps(PoseGraph2()).empty());
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    Rng rng(seed);
    auto graph = random_walk<SE2d>(rng, 1 + static_cast<int>(rng.below(20)));
    for (std::size_t k = graph.edges.size(); k > 1; --k)
      std::swap(graph.edges[k - 1], graph.edges[rng.below(k)]);
    int known = 1;
    const auto steps = replay_steps(graph);
    EXPECT_EQ(steps.size(), graph.edges.size());
    for (const auto& step : steps) {
      if (step.new_pose >= 0) {
        EXPECT_EQ(step.new_pose, known++);
      }
      EXPECT_LT(std::max(step.edge.from, step.edge.to), known);
    }
    EXPECT_EQ(known, graph.size());
  }
}

}  // namespace
}  // namespace wayfare::tests
