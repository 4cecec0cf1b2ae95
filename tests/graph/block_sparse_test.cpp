#include <wayfare/graph/linear_solver.hpp>

#include <set>

#include <gtest/gtest.h>

#include <wayfare/core/random.hpp>
#include <wayfare/graph/scalar_solver.hpp>

#include <wayfare/testing/detail/block_matrices.hpp>

namespace wayfare {
namespace {

using testing::fill;
using testing::random_pairs;

TEST(BlockSparse, HasExactlyThePattern) {
  Rng rng(1);
  for (const auto& [columns, couplings] : {std::pair{1, 0}, {2, 5}, {17, 0}, {25, 60}, {9, 200}}) {
    const auto pairs = random_pairs(rng, columns, couplings);
    const BlockSparse<3> h(columns, pairs);
    std::set<std::pair<int, int>> want;  // (column, row)
    for (const auto& [r, c] : pairs) want.emplace(std::max(r, c), std::min(r, c));
    for (int c = 0; c < columns; ++c) want.emplace(c, c);
    ASSERT_EQ(h.columns(), columns);
    ASSERT_EQ(static_cast<std::size_t>(h.blocks()), want.size());
    int index = 0;
    for (const auto& [c, r] : want) {  // in the documented order
      EXPECT_EQ(h.find(r, c), index);
      EXPECT_EQ(h.rows()[static_cast<std::size_t>(index)], r);
      EXPECT_GE(index, h.starts()[static_cast<std::size_t>(c)]);
      EXPECT_LT(index, h.starts()[static_cast<std::size_t>(c) + 1]);
      if (r == c) {
        EXPECT_EQ(h.diagonal_index(c), index);
      }
      ++index;
    }
  }
}

TEST(BlockSparse, BlocksKeepTheirAddressesAndStartAtZero) {
  Rng rng(2);
  BlockSparse<2> h(6, random_pairs(rng, 6, 10));
  for (int i = 0; i < h.blocks(); ++i) EXPECT_TRUE(h.block(i).isZero());
  const double* first = h.data(0);
  for (int i = 0; i < h.blocks(); ++i) h.block(i).setConstant(i);
  for (int i = 0; i < h.blocks(); ++i) {
    EXPECT_EQ(h.data(i), first + 4 * i);
    EXPECT_EQ(std::as_const(h).block(i), Eigen::Matrix2d::Constant(i));
  }
  h.set_zero();
  EXPECT_EQ(h.data(0), first);
  for (int i = 0; i < h.blocks(); ++i) EXPECT_TRUE(h.block(i).isZero());
}

TEST(BlockSparse, RejectsBlocksOutsideTheMatrixAndMissingBlocks) {
  using Pairs = std::vector<std::pair<int, int>>;
  EXPECT_DEATH(BlockSparse<3>(2, Pairs{{0, 2}}), "inside the matrix");
  EXPECT_DEATH(BlockSparse<3>(2, Pairs{{-1, 0}}), "inside the matrix");
  EXPECT_DEATH(BlockSparse<3>(2, Pairs{{1, 1}}), "inside the matrix");
  EXPECT_DEATH((void)BlockSparse<3>(3, Pairs{{0, 1}}).find(0, 2), "in the pattern");
}

// The oracle is P H Pᵀ with dense matrices.
TEST(ScalarExpansion, EqualsThePermutedMatrix) {
  constexpr int kBlock = 3;
  Rng rng(3);
  for (const int columns : {1, 2, 12}) {
    BlockSparse<kBlock> h(columns, random_pairs(rng, columns, 2 * columns));
    std::vector<int> position(static_cast<std::size_t>(columns));
    for (int i = 0; i < columns; ++i) position[static_cast<std::size_t>(i)] = i;
    for (std::size_t i = position.size(); i > 1; --i)
      std::swap(position[i - 1], position[static_cast<std::size_t>(rng.below(i))]);
    Eigen::MatrixXd p = Eigen::MatrixXd::Zero(columns * kBlock, columns * kBlock);
    for (int i = 0; i < columns; ++i)
      p.block<kBlock, kBlock>(position[static_cast<std::size_t>(i)] * kBlock, i * kBlock)
          .setIdentity();
    ScalarExpansion<kBlock> expansion;
    expansion.build(h, position);
    for (int again = 0; again < 2; ++again) {  // different values in the same layout
      const Eigen::MatrixXd dense = fill(h, rng);
      expansion.fill(h);
      const Eigen::MatrixXd want = p * dense * p.transpose();
      const Eigen::MatrixXd got(expansion.matrix());
      EXPECT_EQ(got, Eigen::MatrixXd(want.triangularView<Eigen::Upper>()));
    }
    const Eigen::VectorXd x = Eigen::VectorXd::LinSpaced(columns * kBlock, 1.0, 2.0);
    Eigen::VectorXd moved, back(x.size());
    expansion.permute(x, moved);
    EXPECT_EQ(moved, Eigen::VectorXd(p * x));
    expansion.unpermute(moved, back);
    EXPECT_EQ(back, x);
  }
}

}  // namespace
}  // namespace wayfare
