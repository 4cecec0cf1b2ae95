#include <wayfare/graph/linear_solver.hpp>

#include <algorithm>

#include <gtest/gtest.h>

#include <Eigen/SparseCholesky>

#include <wayfare/graph/detail/scalar_solver.hpp>

#include "patterns.hpp"
#include "solvers.hpp"

namespace wayfare {
namespace {

using tests::fill;
using tests::random_pairs;

template <class Solver>
class LinearSolverTest : public ::testing::Test {};
TYPED_TEST_SUITE(LinearSolverTest, AllSolvers);

TYPED_TEST(LinearSolverTest, AgreesWithADenseFactorisationOnAnyPattern) {
  constexpr int kBlock = TypeParam::kBlock;
  Rng rng(7);
  for (const auto& [columns, couplings] : {std::pair{1, 0}, {2, 1}, {9, 0}, {30, 60}, {40, 400}}) {
    BlockSparse<kBlock> h(columns, random_pairs(rng, columns, couplings));
    TypeParam solver;
    tests::expect_solves(solver, h, rng);
  }
}

TYPED_TEST(LinearSolverTest, NamesTheIndefiniteBlockAndSolvesTheNext) {
  constexpr int kBlock = TypeParam::kBlock;
  Rng rng(8);
  BlockSparse<kBlock> h(12, random_pairs(rng, 12, 20));
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

// The concept requires all three functions, and the outcome of a factorisation.
struct SaysNothing {
  static constexpr int kBlock = 3;
  void analyse(const BlockSparse<3>&) {}
  bool factorise(const BlockSparse<3>&) { return true; }
  void solve_in_place(Eigen::VectorXd&) {}
};
static_assert(!LinearSolver<SaysNothing>);
static_assert(!ThreadedSolver<EigenSolver<3>>);
static_assert(
    LinearSolver<ScalarSolver<3, Eigen::SimplicialLLT<ScalarExpansion<3>::Matrix, Eigen::Upper>>>);

TEST(MinimumDegreeOrder, IsAPermutation) {
  Rng rng(9);
  for (const int columns : {1, 2, 50}) {
    auto position = minimum_degree_order(BlockSparse<6>(columns, random_pairs(rng, columns, 90)));
    std::sort(position.begin(), position.end());
    for (int i = 0; i < columns; ++i) EXPECT_EQ(position[static_cast<std::size_t>(i)], i);
  }
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
