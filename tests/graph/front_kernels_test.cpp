// The dense kernels of every instruction set this CPU supports, compared with dense matrices.

#include "graph/cholesky/kernels.hpp"

#include <numeric>
#include <vector>

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include <wayfare/core/random.hpp>

namespace wayfare::cholesky {
namespace {

using Eigen::MatrixXd;

MatrixXd random_matrix(Rng& rng, int rows, int columns) {
  MatrixXd m(rows, columns);
  for (double& v : m.reshaped()) v = rng.uniform(-1, 1);
  return m;
}

/// A front of p pivots and m rows in the memory layout of the factorisation.
struct Case {
  int p, m, ld11, ld21;
  MatrixXd dense;  // of all p + m
  std::vector<double> l11, l21, update, z11, z21;

  Case(Rng& rng, int block, int columns, int rows)
      : p(columns * block),
        m(rows * block),
        ld11(columns == 1 || p == 6 ? p : padded(p)),
        ld21(padded(m)),
        dense(random_matrix(rng, p + m, p + m)),
        l11(static_cast<std::size_t>(ld11 * p + kPad), 0.0),
        l21(static_cast<std::size_t>(ld21 * p + kPad), 0.0),
        update(static_cast<std::size_t>(ld21 * m + kPad), 0.0),
        z11(l11),
        z21(l21) {
    dense = (dense * dense.transpose()).eval() + MatrixXd::Identity(p + m, p + m);
    view(l11, ld11, p, p).triangularView<Eigen::Lower>() = dense.topLeftCorner(p, p);
    view(l21, ld21, m, p) = dense.bottomLeftCorner(m, p);
  }
  static Eigen::Map<MatrixXd, 0, Eigen::OuterStride<>> view(std::vector<double>& v, int ld,
                                                            int rows, int columns) {
    return {v.data(), rows, columns, Eigen::OuterStride<>(ld)};
  }
  Panel panel() { return {l11.data(), l21.data(), p, m, ld11, ld21}; }
  Panel inverse() { return {z11.data(), z21.data(), p, m, ld11, ld21}; }
};

template <class Check>
void on_every_front(const Check& check) {
  for (const Isa isa : {Isa::baseline, Isa::avx2, Isa::avx512}) {
    if (!runs_here(isa)) continue;
    for (const int block : {2, 3, 6}) {
      Rng rng(51);
      for (const auto& [columns, rows] : {std::pair{1, 0},
                                          {1, 1},
                                          {1, 5},
                                          {2, 3},
                                          {3, 0},
                                          {4, 9},
                                          {5, 2},
                                          {7, 13},
                                          {11, 6},
                                          {16, 0}}) {
        SCOPED_TRACE(::testing::Message() << "set " << static_cast<int>(isa) << ", blocks of "
                                          << block << ", " << columns << " and " << rows);
        Case c(rng, block, columns, rows);
        check(kernels_for(isa, block), c, block);
      }
    }
  }
}

TEST(FrontKernels, FactoriseAndLeaveTheUpdate) {
  on_every_front([](const FrontKernels& k, Case& c, int) {
    ASSERT_EQ(k.factorise(c.panel()), -1);
    const MatrixXd l = c.dense.topLeftCorner(c.p, c.p).llt().matrixL();
    MatrixXd got = Case::view(c.l11, c.ld11, c.p, c.p).triangularView<Eigen::Lower>();
    got.diagonal() = got.diagonal().cwiseInverse();  // stored as reciprocals
    EXPECT_LT((got - l).norm(), 1e-11 * l.norm());
    MatrixXd below = c.dense.bottomLeftCorner(c.m, c.p).transpose();
    if (c.m > 0) l.triangularView<Eigen::Lower>().solveInPlace(below);
    EXPECT_LT((Case::view(c.l21, c.ld21, c.m, c.p) - below.transpose()).norm(), 1e-10 * l.norm());
    k.update(c.panel(), c.update.data(), c.ld21);
    MatrixXd sum = Case::view(c.update, c.ld21, c.m, c.m) + below.transpose() * below;
    sum.triangularView<Eigen::StrictlyUpper>().setZero();
    EXPECT_LT(sum.norm(), 1e-10 * (1.0 + below.squaredNorm()));
  });
}

TEST(FrontKernels, NameThePivotThatIsNotPositive) {
  on_every_front([](const FrontKernels& k, Case& c, int) {
    const Case good = c;
    for (int pivot = 0; pivot < c.p; ++pivot) {
      c = good;
      c.l11[static_cast<std::size_t>(pivot * c.ld11 + pivot)] = -1.0;
      EXPECT_EQ(k.factorise(c.panel()), pivot);
    }
  });
}

// Rows past the pivots are every other block; the blocks between must be unchanged.
TEST(FrontKernels, SubstituteForwardAndBackward) {
  on_every_front([](const FrontKernels& k, Case& c, int block) {
    ASSERT_EQ(k.factorise(c.panel()), -1);
    const int columns = c.p / block, rows = c.m / block;
    std::vector<int> index(static_cast<std::size_t>(rows));
    for (int i = 0; i < rows; ++i) index[static_cast<std::size_t>(i)] = columns + 1 + 2 * i;
    Eigen::VectorXd y = Eigen::VectorXd::LinSpaced((columns + 2 * rows + 1) * block, -1.0, 2.0);
    const Eigen::VectorXd b = y;
    std::vector<double> scratch(static_cast<std::size_t>(padded(c.p) + c.ld21));
    k.forward(c.panel(), 0, index.data(), y.data(), scratch.data());
    const MatrixXd l = c.dense.topLeftCorner(c.p, c.p).llt().matrixL();
    const MatrixXd below = Case::view(c.l21, c.ld21, c.m, c.p);
    Eigen::VectorXd want = b;
    want.head(c.p) = l.triangularView<Eigen::Lower>().solve(b.head(c.p));
    for (int i = 0; i < rows; ++i)
      want.segment(index[static_cast<std::size_t>(i)] * block, block) -=
          below.middleRows(i * block, block) * want.head(c.p);
    EXPECT_LT((y - want).norm(), 1e-9 * want.norm());
    k.backward(c.panel(), 0, index.data(), y.data(), scratch.data());
    Eigen::VectorXd right = want.head(c.p);
    for (int i = 0; i < rows; ++i)
      right -= below.middleRows(i * block, block).transpose() *
               want.segment(index[static_cast<std::size_t>(i)] * block, block);
    want.head(c.p) = l.transpose().triangularView<Eigen::Upper>().solve(right);
    EXPECT_LT((y - want).norm(), 1e-8 * want.norm());
  });
}

TEST(FrontKernels, InvertAFrontWhoseRowsAreInverted) {
  on_every_front([](const FrontKernels& k, Case& c, int) {
    ASSERT_EQ(k.factorise(c.panel()), -1);
    const MatrixXd z = c.dense.inverse();
    Case::view(c.update, c.ld21, c.m, c.m) = z.bottomRightCorner(c.m, c.m);
    std::vector<double> scratch(static_cast<std::size_t>(padded(c.p) * (2 * c.p + c.m)));
    k.invert(c.panel(), c.inverse(), c.update.data(), scratch.data());
    EXPECT_LT((Case::view(c.z11, c.ld11, c.p, c.p) - z.topLeftCorner(c.p, c.p)).norm(),
              1e-9 * z.norm());
    EXPECT_LT((Case::view(c.z21, c.ld21, c.m, c.p) - z.bottomLeftCorner(c.m, c.p)).norm(),
              1e-9 * z.norm());
  });
}

}  // namespace
}  // namespace wayfare::cholesky
