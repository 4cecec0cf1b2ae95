#include <gtest/gtest.h>

#include <Eigen/Cholesky>

#include <wayfare/core/random.hpp>

#include "graph/solvers.hpp"

namespace wayfare {
namespace {

template <int N>
BlockSparse<N> random_pattern(Rng& rng, int columns, int couplings) {
  std::vector<std::pair<int, int>> pairs;
  for (int k = 0; k < couplings; ++k) {
    const int a = static_cast<int>(rng.below(static_cast<std::uint64_t>(columns)));
    const int b = static_cast<int>(rng.below(static_cast<std::uint64_t>(columns)));
    if (a != b) pairs.emplace_back(a, b);
  }
  return BlockSparse<N>(columns, pairs);
}

/// Fills the pattern with a diagonally dominant matrix; returns it dense.
template <int N>
Eigen::MatrixXd fill(BlockSparse<N>& h, Rng& rng) {
  const int n = h.columns() * N;
  Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(n, n);
  for (int c = 0; c < h.columns(); ++c) {
    for (int i = h.starts()[static_cast<std::size_t>(c)]; i < h.diagonal_index(c); ++i) {
      for (double& v : h.block(i).reshaped()) v = rng.uniform(-1, 1);
      const int r = h.rows()[static_cast<std::size_t>(i)];
      dense.block<N, N>(r * N, c * N) = h.block(i);
      dense.block<N, N>(c * N, r * N) = h.block(i).transpose();
    }
  }
  for (int k = 0; k < n; ++k) dense(k, k) = dense.row(k).cwiseAbs().sum() + rng.uniform(0.1, 1.0);
  for (int c = 0; c < h.columns(); ++c) {
    h.block(h.diagonal_index(c)) = dense.block<N, N>(c * N, c * N);
  }
  return dense;
}

template <class Solver>
class LinearSolverTest : public testing::Test {};
TYPED_TEST_SUITE(LinearSolverTest, AllSolvers);

TYPED_TEST(LinearSolverTest, AgreesWithADenseFactorisationOnAnyPattern) {
  constexpr int kBlock = TypeParam::kBlock;
  Rng rng(7);
  for (const auto& [columns, couplings] : {std::pair{1, 0}, {2, 1}, {9, 0}, {30, 60}, {40, 400}}) {
    auto h = random_pattern<kBlock>(rng, columns, couplings);
    TypeParam solver;
    solver.analyse(h);
    for (int again = 0; again < 2; ++again) {  // other values on the kept pattern
      const Eigen::MatrixXd dense = fill(h, rng);
      ASSERT_TRUE(solver.factorise(h).ok);
      const Eigen::VectorXd b = Eigen::VectorXd::LinSpaced(dense.rows(), -1.0, 2.0);
      Eigen::VectorXd x = b;
      solver.solve_in_place(x);
      EXPECT_LT((dense.llt().solve(b) - x).norm(), 1e-12 * b.norm());
    }
  }
}

TYPED_TEST(LinearSolverTest, NamesTheIndefiniteBlockAndServesTheNext) {
  constexpr int kBlock = TypeParam::kBlock;
  Rng rng(8);
  auto h = random_pattern<kBlock>(rng, 12, 20);
  TypeParam solver;
  solver.analyse(h);
  fill(h, rng);
  h.block(h.diagonal_index(5))(0, 0) = -1.0;
  const FactorOutcome outcome = solver.factorise(h);
  EXPECT_FALSE(outcome.ok);
  EXPECT_EQ(outcome.block, 5);  // the others are diagonally dominant: none fails before it
  fill(h, rng);
  EXPECT_TRUE(solver.factorise(h).ok);
}

TEST(MinimumDegreeOrder, EliminatesTheLeavesOfAStarBeforeItsHub) {
  // Eliminating the hub first would fill the whole matrix.
  std::vector<std::pair<int, int>> star;
  for (int leaf = 1; leaf < 20; ++leaf) star.emplace_back(0, leaf);
  const auto position = minimum_degree_order(BlockSparse<3>(20, star));
  EXPECT_GE(position[0], 18);
}

}  // namespace
}  // namespace wayfare
