#include <wayfare/filter/covariance_intersection.hpp>

#include <cmath>
#include <limits>

#include <gtest/gtest.h>
#include <Eigen/Cholesky>

#include <wayfare/core/random.hpp>

namespace wayfare {
namespace {

constexpr int kStates = 5, kRows = 3;
using Vector = Eigen::Matrix<double, kStates, 1>;
using Covariance = Eigen::Matrix<double, kStates, kStates>;
using Rows = Eigen::Matrix<double, kRows, kStates>;
using Noise = Eigen::Matrix3d;

template <class Matrix>
Matrix random_matrix(Rng& rng) {
  return Matrix::NullaryExpr([&] { return rng.normal(0, 1); });
}
template <class Matrix>
Matrix random_covariance(Rng& rng) {
  const Matrix a = random_matrix<Matrix>(rng);
  return a * a.transpose() + 0.1 * Matrix::Identity();
}

template <class Matrix>
Matrix inverse(const Matrix& positive_definite) {
  return positive_definite.llt().solve(Matrix::Identity());
}
template <class Matrix>
double log_determinant(const Matrix& positive_definite) {
  return 2 * Matrix(positive_definite.llt().matrixL()).diagonal().array().log().sum();
}
/// Whether M + t I is positive definite.
bool is_above(const Covariance& m, double t) {
  return Covariance(m + t * Covariance::Identity()).llt().info() == Eigen::Success;
}

struct Problem {
  Covariance P;
  Rows C;
  Noise R;
  Eigen::Vector3d innovation;

  explicit Problem(Rng& rng)
      : P(random_covariance<Covariance>(rng)),
        C(random_matrix<Rows>(rng)),
        R(std::exp(rng.uniform(-4, 1)) * random_covariance<Noise>(rng)),
        innovation(random_matrix<Eigen::Vector3d>(rng)) {}

  [[nodiscard]] Covariance information(double omega) const {
    return (1 - omega) * inverse(P) + omega * C.transpose() * inverse(R) * C;
  }
};

TEST(CovarianceIntersection, MatchesTheInformationForm) {
  Rng rng(1);
  int used = 0;
  for (int i = 0; i < 200; ++i) {
    const Problem p(rng);
    const auto fused = covariance_intersection<kStates, kRows>(p.P, p.C, p.R, p.innovation);
    ASSERT_TRUE(fused);
    const Covariance want = inverse(p.information(fused->omega));
    ASSERT_LT((fused->covariance - want).norm(), 1e-9 * want.norm());
    // x⁺ = P⁺ ((1 − ω) P⁻¹ x + ω Cᵀ R⁻¹ z) with x = 0.
    const Vector x = want * fused->omega * p.C.transpose() * inverse(p.R) * p.innovation;
    ASSERT_LT((fused->correction - x).norm(), 1e-9 * (1 + x.norm()));
    used += fused->omega > 0;
  }
  EXPECT_GT(used, 50);
}

TEST(CovarianceIntersection, NoOtherWeightHasASmallerDeterminant) {
  Rng rng(2);
  for (int i = 0; i < 100; ++i) {
    const Problem p(rng);
    const auto fused = covariance_intersection<kStates, kRows>(p.P, p.C, p.R, p.innovation);
    ASSERT_TRUE(fused);
    const double best = log_determinant(p.information(fused->omega));
    for (double omega = 0; omega < 1; omega += 0.01)
      ASSERT_LE(log_determinant(p.information(omega)), best + 1e-9) << omega;
  }
}

/// For any correlation: the worst joint covariances [P X; Xᵀ R] have X = P^½ U R^½ with orthonormal
/// columns U, and P⁺ covers the true covariance of the fused error.
TEST(CovarianceIntersection, IsConsistentForAnyCorrelation) {
  Rng rng(3);
  int close = 0;
  for (int i = 0; i < 300; ++i) {
    const Problem p(rng);
    const auto fused = covariance_intersection<kStates, kRows>(p.P, p.C, p.R, p.innovation);
    ASSERT_TRUE(fused);
    const double w = fused->omega;
    if (w == 0) continue;
    const Noise inflated = (1 - w) / w * p.R + p.C * p.P * p.C.transpose();
    const Eigen::Matrix<double, kStates, kRows> K = p.P * p.C.transpose() * inverse(inflated);
    const Covariance A = Covariance::Identity() - K * p.C;
    const Vector mirror = random_matrix<Vector>(rng).normalized();
    const Covariance reflection = Covariance::Identity() - 2 * mirror * mirror.transpose();
    const Eigen::Matrix<double, kStates, kRows> X = Covariance(p.P.llt().matrixL()) *
                                                    reflection.leftCols<kRows>() *
                                                    Noise(p.R.llt().matrixL()).transpose();
    const Covariance cross = A * X * K.transpose();
    const Covariance truth =
        A * p.P * A.transpose() + K * p.R * K.transpose() + cross + cross.transpose();
    const Covariance gap = fused->covariance - truth;
    ASSERT_TRUE(is_above(gap, 1e-9 * truth.norm()));
    close += !is_above(gap, -0.02 * truth.norm());
  }
  EXPECT_GT(close, 30);  // worst-case correlations: the margin is small
}

TEST(CovarianceIntersection, IgnoresAnUninformativeMeasurement) {
  Rng rng(4);
  const Covariance P = random_covariance<Covariance>(rng);
  const Rows C = random_matrix<Rows>(rng);
  const Noise vague = 1e6 * Noise::Identity();
  const auto fused = covariance_intersection<kStates, kRows>(P, C, vague, Eigen::Vector3d(1, 2, 3));
  ASSERT_TRUE(fused);
  EXPECT_EQ(fused->omega, 0.0);
  EXPECT_TRUE(fused->correction.isZero(0));
  EXPECT_TRUE(fused->covariance == P);
}

TEST(CovarianceIntersection, AMuchBetterMeasurementDominates) {
  Rng rng(5);
  const Noise P = 100 * random_covariance<Noise>(rng), R = 1e-4 * Noise::Identity();
  const Eigen::Vector3d z(1, -2, 0.5);
  const auto fused = covariance_intersection<3, 3>(P, Noise::Identity(), R, z);
  ASSERT_TRUE(fused);
  EXPECT_GT(fused->omega, 0.99);
  EXPECT_LT((fused->correction - z).norm(), 1e-4);
}

TEST(CovarianceIntersection, RejectsInvalidCovariances) {
  Rng rng(6);
  const Problem p(rng);
  Noise bad = p.R;
  bad(0, 0) = -1;
  Covariance nan = p.P;
  nan(1, 1) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE((covariance_intersection<kStates, kRows>(p.P, p.C, bad, p.innovation)));
  EXPECT_FALSE((covariance_intersection<kStates, kRows>(nan, p.C, p.R, p.innovation)));
  EXPECT_FALSE((covariance_intersection<kStates, kRows>(-p.P, p.C, p.R, p.innovation)));
}

}  // namespace
}  // namespace wayfare
