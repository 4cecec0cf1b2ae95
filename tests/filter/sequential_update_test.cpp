#include <wayfare/filter/sequential_update.hpp>

#include <array>
#include <cmath>
#include <cstddef>

#include <gtest/gtest.h>
#include <Eigen/Core>
#include <Eigen/LU>

#include <wayfare/core/random.hpp>

namespace wayfare {
namespace {

constexpr int kUnknowns = 4;
using Unknowns = Eigen::Matrix<double, kUnknowns, 1>;
using Square = Eigen::Matrix<double, kUnknowns, kUnknowns>;
using PackedCovariance = SymmetricMatrix<double, kUnknowns>;

/// A user's own storage: a full matrix.
struct FullCovariance {
  Square p;

  template <int... Index>
  [[nodiscard]] Unknowns times(const IndexedRow<double, Index...>& h) const {
    Unknowns result;
    for (int i = 0; i < kUnknowns; ++i) result[i] = h.sum([&](int j) { return p(i, j); });
    return result;
  }
  void subtract_outer(const Unknowns& v, double scale) { p -= v * scale * v.transpose(); }
  [[nodiscard]] Square dense() const { return p; }
};

/// The library's view of a full matrix, with the matrix.
struct OwnDenseCovariance {
  Square p;

  template <int... Index>
  [[nodiscard]] Unknowns times(const IndexedRow<double, Index...>& h) const {
    Square copy = p;
    return DenseCovariance<Square>{copy}.times(h);
  }
  void subtract_outer(const Unknowns& v, double scale) {
    DenseCovariance<Square>{p}.subtract_outer(v, scale);
  }
  [[nodiscard]] Square dense() const { return p; }
};

using RowA = IndexedRow<double, 0, 2>;
using RowB = IndexedRow<double, 1, 2, 3>;
static_assert(SequentialCovariance<PackedCovariance, RowA>);
static_assert(SequentialCovariance<FullCovariance, RowA>);
static_assert(SequentialCovariance<DenseCovariance<Square>, RowA>);
static_assert(!SequentialCovariance<Square, RowA>);

Square random_covariance(Rng& rng) {
  Square a;
  for (double& x : a.reshaped()) x = rng.normal();
  return a * a.transpose() + 0.1 * Square::Identity();
}

template <class P>
P stored(const Square& p) {
  P result;
  if constexpr (requires { result.p; }) {
    result.p = p;
  } else {
    for (int j = 0; j < kUnknowns; ++j)
      for (int i = 0; i <= j; ++i) result(i, j) = p(i, j);
  }
  return result;
}

template <class P>
class SequentialUpdate : public ::testing::Test {};
using Storages = ::testing::Types<PackedCovariance, FullCovariance, OwnDenseCovariance>;
TYPED_TEST_SUITE(SequentialUpdate, Storages);

// P = 4, R = 1, innovation 5, 3 of the state's 4 elements uncorrelated with it: gain 4/5, so the
// correction is 4 and the variance 4·(1 − 4/5) = 0.8; 5²/(4 + 1) = 5.
TYPED_TEST(SequentialUpdate, GivesTheScalarKalmanFilter) {
  Square start = Square::Identity();
  start(2, 2) = 4;
  auto p = stored<TypeParam>(start);
  Unknowns correction = Unknowns::Zero();
  const IndexedRow<double, 2> row{{1.0}};
  EXPECT_DOUBLE_EQ(sequential_update(p, correction, row, 5.0, 1.0), 5.0);
  EXPECT_DOUBLE_EQ(correction[2], 4.0);
  EXPECT_NEAR(p.dense()(2, 2), 0.8, 1e-15);
  for (const int other : {0, 1, 3}) {
    EXPECT_EQ(correction[other], 0.0);
    EXPECT_EQ(p.dense()(other, other), 1.0);
  }
}

// Two numbers with independent noise, one after the other, are the vector update with
// K = P Hᵀ (H P Hᵀ + R)⁻¹ taken at once; their normalised squares add up to νᵀ S⁻¹ ν.
TYPED_TEST(SequentialUpdate, OfTwoNumbersIsTheVectorUpdate) {
  Rng rng(5);
  for (int k = 0; k < 50; ++k) {
    const Square start = random_covariance(rng);
    const RowA a{{rng.normal(), rng.normal()}};
    const RowB b{{rng.normal(), rng.normal(), rng.normal()}};
    Eigen::Matrix<double, 2, kUnknowns> h;
    h << a.value[0], 0, a.value[1], 0, 0, b.value[0], b.value[1], b.value[2];
    const Eigen::Vector2d innovation(rng.normal(), rng.normal());
    const Eigen::Vector2d r(0.3, 0.7);
    const Eigen::Matrix2d s_inverse =
        (h * start * h.transpose() + Eigen::Matrix2d(r.asDiagonal())).inverse();
    const Eigen::Matrix<double, kUnknowns, 2> gain = start * h.transpose() * s_inverse;

    auto p = stored<TypeParam>(start);
    std::array<double, kUnknowns> correction{};
    double nis = sequential_update(p, correction, a, innovation[0], r[0]);
    nis += sequential_update(p, correction, b, innovation[1], r[1]);
    const Unknowns expected = gain * innovation;
    for (int i = 0; i < kUnknowns; ++i)
      EXPECT_NEAR(correction[static_cast<std::size_t>(i)], expected[i], 1e-11);
    EXPECT_LT((p.dense() - (start - gain * h * start)).norm(), 1e-11 * start.norm());
    EXPECT_NEAR(nis, innovation.dot(s_inverse * innovation), 1e-11);
  }
}

// With noise v correlated with the state, E[x v] = c: cross P hᵀ + c, variance h P hᵀ + 2 h c. Here
// P = 1, c = −½, R = 1: gain ½/(1 − 1 + 1), variance 1 − ¼.
TYPED_TEST(SequentialUpdate, TakesNoiseCorrelatedWithTheState) {
  auto p = stored<TypeParam>(Square::Identity());
  Unknowns correction = Unknowns::Zero();
  const IndexedRow<double, 1> row{{1.0}};
  auto expected = expected_innovation(p, row);
  EXPECT_EQ(expected.variance, 1.0);
  expected.cross[1] -= 0.5;
  expected.variance -= 1.0;
  EXPECT_DOUBLE_EQ(sequential_update(p, correction, row, expected, 3.0, 1.0), 9.0);
  EXPECT_DOUBLE_EQ(correction[1], 1.5);
  EXPECT_DOUBLE_EQ(p.dense()(1, 1), 0.75);
}

// A variance that rounding made negative counts as zero: the weight is 1/R.
TYPED_TEST(SequentialUpdate, NeverWeighsByANegativeVariance) {
  auto p = stored<TypeParam>(Square::Identity());
  Unknowns correction = Unknowns::Zero();
  const IndexedRow<double, 0> row{{1.0}};
  auto expected = expected_innovation(p, row);
  expected.variance = -3.0;
  EXPECT_DOUBLE_EQ(sequential_update(p, correction, row, expected, 2.0, 2.0), 2.0);
  EXPECT_DOUBLE_EQ(correction[0], 1.0);
}

TYPED_TEST(SequentialUpdate, MultipliesInTheOrderOfTheGain) {
  const auto left_first = [](double cross, double left, double weight) {
    return cross * left * weight;
  };
  Rng rng(8);
  int different = 0;
  for (int k = 0; k < 100; ++k) {
    Square start = Square::Identity();
    start(0, 0) = std::exp(rng.normal());
    const double innovation = rng.normal();
    auto p = stored<TypeParam>(start);
    auto q = p;
    Unknowns usual = Unknowns::Zero(), ordered = Unknowns::Zero();
    const IndexedRow<double, 0> row{{1.0}};
    sequential_update(p, usual, row, innovation, 0.3);
    sequential_update(q, ordered, row, expected_innovation(q, row), innovation, 0.3, left_first);
    const double weight = 1.0 / (start(0, 0) + 0.3);
    EXPECT_EQ(usual[0], start(0, 0) * (innovation * weight));
    EXPECT_EQ(ordered[0], (start(0, 0) * innovation) * weight);
    different += usual[0] != ordered[0] ? 1 : 0;
  }
  EXPECT_GT(different, 0);
}

}  // namespace
}  // namespace wayfare
