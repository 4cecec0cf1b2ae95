#include <wayfare/graph/linear_solver.hpp>

#include <limits>

#include <gtest/gtest.h>

#include "core/counted_heap.hpp"
#include "shapes.hpp"

namespace wayfare {
namespace {

using tests::all_shapes;
using tests::fill;

template <class Solver>
class MultifrontalCholeskyTest : public ::testing::Test {};
using BlockSizes =
    ::testing::Types<MultifrontalCholesky<2>, MultifrontalCholesky<3>, MultifrontalCholesky<6>>;
TYPED_TEST_SUITE(MultifrontalCholeskyTest, BlockSizes);

TYPED_TEST(MultifrontalCholeskyTest, AgreesWithADenseFactorisationOnEveryShape) {
  Rng rng(31);
  TypeParam solver;  // reused: nothing of the previous pattern remains
  for (const auto& shape : all_shapes(rng)) {
    SCOPED_TRACE(shape.name + " of " + std::to_string(shape.columns));
    BlockSparse<TypeParam::kBlock> h(shape.columns, shape.pairs);
    tests::expect_solves(solver, h, rng);
  }
}

// Each block column in turn; all others are diagonally dominant, so none fails before it.
TYPED_TEST(MultifrontalCholeskyTest, NamesTheBlockColumnThatIsNotPositive) {
  constexpr int kBlock = TypeParam::kBlock;
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  Rng rng(32);
  const auto shape = tests::grid(5, 4);
  BlockSparse<kBlock> h(shape.columns, shape.pairs);
  TypeParam solver;
  solver.analyse(h);
  for (int column = 0; column < shape.columns; ++column) {
    for (const double bad :
         {-1.0, 0.0, kInfinity, -kInfinity, std::numeric_limits<double>::quiet_NaN()}) {
      fill(h, rng);
      h.block(h.diagonal_index(column))(kBlock - 1, kBlock - 1) = bad;
      const FactorOutcome outcome = solver.factorise(h);
      EXPECT_FALSE(outcome.ok);
      EXPECT_EQ(outcome.block, column) << bad;
    }
  }
  fill(h, rng);
  EXPECT_TRUE(solver.factorise(h).ok);
}

TYPED_TEST(MultifrontalCholeskyTest, IsDeterministicAndDoesNotAllocateAgain) {
  WAYFARE_NEEDS_COUNTED_HEAP();
  Rng rng(33);
  const auto shape = tests::grid(9, 9);
  BlockSparse<TypeParam::kBlock> h(shape.columns, shape.pairs);
  const Eigen::VectorXd b = fill(h, rng).col(3);
  TypeParam solver, other;
  solver.analyse(h);
  ASSERT_TRUE(solver.factorise(h).ok);
  Eigen::VectorXd first = b, again = b, elsewhere = b;
  solver.solve_in_place(first);
  const std::size_t before = tests::allocations;
  ASSERT_TRUE(solver.factorise(h).ok);
  solver.solve_in_place(again);
  EXPECT_EQ(tests::allocations, before);
  EXPECT_EQ(first, again);
  other.analyse(h);
  ASSERT_TRUE(other.factorise(h).ok);
  other.solve_in_place(elsewhere);
  EXPECT_EQ(first, elsewhere);
}

TYPED_TEST(MultifrontalCholeskyTest, DoesNotAllocateAgainOnTwoThreads) {
  WAYFARE_NEEDS_COUNTED_HEAP();
  Rng rng(34);
  const auto shape = tests::grid(60, 60);
  BlockSparse<TypeParam::kBlock> h(shape.columns, shape.pairs);
  tests::fill_dominant(h, rng);
  TypeParam solver;
  solver.set_threads(2);
  solver.analyse(h);
  ASSERT_TRUE(solver.factorise(h).ok);
  Eigen::VectorXd x = Eigen::VectorXd::Ones(shape.columns * TypeParam::kBlock);
  const std::size_t before = tests::allocations;
  ASSERT_TRUE(solver.factorise(h).ok);
  solver.solve_in_place(x);
  EXPECT_EQ(tests::allocations, before);
}

}  // namespace
}  // namespace wayfare
