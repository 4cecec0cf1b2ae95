#include <wayfare/graph/linear_solver.hpp>

#include <gtest/gtest.h>

#include <wayfare/testing/detail/block_matrices.hpp>
#include "core/counted_heap.hpp"

namespace wayfare {
namespace {

using testing::fill;

template <class Solver>
class MultifrontalCholeskyTest : public ::testing::Test {};
using BlockSizes =
    ::testing::Types<MultifrontalCholesky<2>, MultifrontalCholesky<3>, MultifrontalCholesky<6>>;
TYPED_TEST_SUITE(MultifrontalCholeskyTest, BlockSizes);

TYPED_TEST(MultifrontalCholeskyTest, IsDeterministicAndDoesNotAllocateAgain) {
  WAYFARE_NEEDS_COUNTED_HEAP();
  Rng rng(33);
  const auto shape = testing::grid(9, 9);
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
  const auto shape = testing::grid(60, 60);
  BlockSparse<TypeParam::kBlock> h(shape.columns, shape.pairs);
  testing::fill_dominant(h, rng);
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
