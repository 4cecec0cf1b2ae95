#include <wayfare/filter/sequential_update.hpp>

#include <gtest/gtest.h>
#include <Eigen/Core>

#include <wayfare/core/random.hpp>
#include <wayfare/testing/detail/positive_definite.hpp>

namespace wayfare {
namespace {

constexpr int kSize = 5;
using Packed = SymmetricMatrix<double, kSize>;
using Dense = Eigen::Matrix<double, kSize, kSize>;

struct Both {
  Packed packed;
  Dense dense;
};

Both random_matrix(Rng& rng) {
  Both m;
  for (int j = 0; j < kSize; ++j)
    for (int i = 0; i <= j; ++i) {
      // Written through the lower triangle, read back through either.
      m.dense(i, j) = m.dense(j, i) = m.packed(j, i) = rng.normal();
    }
  return m;
}

TEST(SymmetricMatrix, StoresEachElementOnce) {
  Rng rng(1);
  EXPECT_EQ(Packed().dense(), Dense::Zero());
  EXPECT_EQ(sizeof(Packed), sizeof(double) * kSize * (kSize + 1) / 2);
  const Both m = random_matrix(rng);
  EXPECT_EQ(m.packed.dense(), m.dense);
  for (int i = 0; i < kSize; ++i)
    for (int j = 0; j < kSize; ++j) EXPECT_EQ(m.packed(i, j), m.dense(j, i));
}

TEST(SymmetricMatrix, OperationsMatchTheDenseMatrix) {
  Rng rng(2);
  for (int round = 0; round < 20; ++round) {
    Both m = random_matrix(rng);
    Eigen::Matrix<double, kSize, 1> v;
    Packed::Vector packed_v;
    for (int i = 0; i < kSize; ++i) v[i] = packed_v[static_cast<std::size_t>(i)] = rng.normal();
    m.packed.subtract_outer(packed_v, 0.7);
    m.dense -= v * v.transpose() * 0.7;
    EXPECT_LT((m.packed.dense() - m.dense).norm(), 1e-15 * 20);

    const IndexedRow<double, 4, 1> row{{2.0, -3.0}};
    Eigen::Matrix<double, 1, kSize> h = Eigen::Matrix<double, 1, kSize>::Zero();
    h[4] = 2.0, h[1] = -3.0;
    const auto ph = m.packed.times(row);
    for (int i = 0; i < kSize; ++i)
      EXPECT_NEAR(ph[static_cast<std::size_t>(i)], (m.dense * h.transpose())[i], 1e-14);
    EXPECT_NEAR(row.sum([&](int i) { return v[i]; }), h.dot(v), 1e-15);

    // x₃ becomes x₃ + h·x.
    m.packed.add_to<3>(row);
    Dense f = Dense::Identity();
    f.row(3) += h;
    m.dense = (f * m.dense * f.transpose()).eval();
    EXPECT_LT((m.packed.dense() - m.dense).norm(), 1e-15 * m.dense.norm() * kSize);

    EXPECT_EQ(m.packed.head<3>(2), m.packed.dense().col(2).head<3>());
    EXPECT_EQ(m.packed.head<2>(4), m.packed.dense().col(4).head<2>());

    m.packed.decouple(2, 9.0);
    m.dense.row(2).setZero();
    m.dense.col(2).setZero();
    m.dense(2, 2) = 9.0;
    EXPECT_LT((m.packed.dense() - m.dense).norm(), 1e-15 * 20);
  }
}

}  // namespace
}  // namespace wayfare
