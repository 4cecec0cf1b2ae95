#include <wayfare/core/gaussian.hpp>

#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/LU>

#include <wayfare/core/gaussian_sampler.hpp>
#include <wayfare/core/se2.hpp>
#include <wayfare/core/se3.hpp>
#include <wayfare/testing/filter_laws.hpp>

namespace wayfare {
namespace {

using std::numbers::pi;
using testing::expect_covariance;
using testing::expect_samples_follow;

template <int N>
using Matrix = Eigen::Matrix<double, N, N>;

/// A positive definite matrix with eigenvalues of very different size, times `size`.
template <int N>
Matrix<N> some_covariance(std::uint64_t seed, double size = 1.0) {
  Rng rng(seed);
  Matrix<N> a;
  for (auto& value : a.reshaped()) value = rng.normal();
  return size * Matrix<N>(a * a.transpose() + 0.1 * Matrix<N>::Identity());
}

TEST(Gaussian, LogDensityInClosedForm) {
  // One dimension: ln N(x; m, s²) = −½((x − m)/s)² − ln(s √2π).
  const Gaussian<Eigen::Matrix<double, 1, 1>> scalar{Eigen::Matrix<double, 1, 1>(2.0),
                                                     Eigen::Matrix<double, 1, 1>(9.0)};
  EXPECT_NEAR(log_density(scalar, Eigen::Matrix<double, 1, 1>(3.5)),
              -0.5 * 0.25 - std::log(3.0 * std::sqrt(2.0 * pi)), 1e-15);
  // Three: by inverse and determinant.
  const Gaussian<Eigen::Vector3d> g{{1, 2, 3}, some_covariance<3>(1)};
  const Eigen::Vector3d x(0.3, -0.4, 5.0), d = x - g.mean;
  const double mahalanobis = d.dot(g.covariance.inverse() * d);
  const double density =
      std::exp(-0.5 * mahalanobis) / std::sqrt(std::pow(2.0 * pi, 3) * g.covariance.determinant());
  EXPECT_NEAR(squared_mahalanobis(g, x), mahalanobis, 1e-12 * mahalanobis);
  EXPECT_NEAR(log_density(g, x), std::log(density), 1e-12);
}

// Equal correlations ρ of three variables: the eigenvalues are 1 − ρ, twice, and 1 + 2ρ.
TEST(Gaussian, DefinitenessDoesNotDependOnUnits) {
  const auto correlated = [](double rho) {
    return Eigen::Matrix3d(Eigen::Matrix3d::Constant(rho) +
                           (1.0 - rho) * Eigen::Matrix3d::Identity());
  };
  for (const Eigen::Vector3d& units : {Eigen::Vector3d(1, 1, 1), Eigen::Vector3d(1e-3, 1e2, 1),
                                       Eigen::Vector3d(1e100, 1e98, 1e97)}) {
    const auto scaled = [&](const Eigen::Matrix3d& m) {
      return Eigen::Matrix3d(units.asDiagonal() * m * units.asDiagonal());
    };
    for (const double rho : {-0.51, 1.01}) {
      EXPECT_FALSE(is_positive_semidefinite(scaled(correlated(rho)))) << rho;
      EXPECT_FALSE(is_positive_definite(scaled(correlated(rho)))) << rho;
    }
    for (const double rho : {-0.5, 1.0})
      EXPECT_TRUE(is_positive_semidefinite(scaled(correlated(rho))));
    for (const double rho : {-0.49, 0.0, 0.99})
      EXPECT_TRUE(is_positive_definite(scaled(correlated(rho)))) << rho;
    Eigen::Matrix3d askew = scaled(correlated(0.5));
    askew(0, 2) *= 1.00001;
    EXPECT_FALSE(is_positive_semidefinite(askew));
  }
  EXPECT_FALSE(is_positive_definite(correlated(1.0)));
  const Eigen::Matrix3d zero = Eigen::Matrix3d::Zero();
  EXPECT_TRUE(is_positive_semidefinite(zero));
  EXPECT_FALSE(is_positive_definite(zero));
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(),
                           std::numeric_limits<double>::infinity(), 1e300, 1e-9}) {
    Eigen::Matrix3d without_variances = zero;
    without_variances(0, 1) = without_variances(1, 0) = bad;
    EXPECT_FALSE(is_positive_semidefinite(without_variances)) << bad;
    EXPECT_FALSE(
        is_positive_semidefinite(Eigen::Matrix3d(Eigen::Vector3d(1, -bad, 1).asDiagonal())));
  }
  EXPECT_TRUE(is_positive_definite(Eigen::Matrix2f(Eigen::Vector2f(1e-6F, 4.0F).asDiagonal())));
}

TEST(Gaussian, DensityIntegratesToOne) {
  // The trapezoid sum of a Gaussian converges faster than any power: steps of 0.25 σ out to ±9 σ.
  const Gaussian<Eigen::Vector2d> g{{0.5, -1.0},
                                    (Eigen::Matrix2d() << 2.0, 0.6, 0.6, 1.0).finished()};
  double sum = 0.0;
  constexpr double kStep = 0.2;
  for (double x = -13.0; x < 14.0; x += kStep) {
    for (double y = -10.0; y < 8.0; y += kStep) {
      sum += std::exp(log_density(g, Eigen::Vector2d(x, y))) * kStep * kStep;
    }
  }
  EXPECT_NEAR(sum, 1.0, 1e-12);
}

TEST(Gaussian, MahalanobisWrapsHeadings) {
  const Gaussian<SE2d> g{SE2d(0, 0.0, 179_deg), 0.01 * Eigen::Matrix3d::Identity()};
  const double two_degrees = 2.0 * pi / 180.0;
  EXPECT_NEAR(squared_mahalanobis(g, SE2d(0, 0.0, -179_deg)), two_degrees * two_degrees / 0.01,
              1e-12);
}

TEST(Gaussian, AnIndefiniteCovarianceGivesNaN) {
  Gaussian<Eigen::Vector2d> g;
  g.covariance << 1, 2, 2, 1;  // eigenvalues 3 and −1
  EXPECT_TRUE(std::isnan(log_density(g, Eigen::Vector2d::Zero().eval())));
  EXPECT_TRUE(std::isnan(squared_mahalanobis(g, Eigen::Vector2d::Zero().eval())));
}

// Dense oracle in information form: Λ = Λ₁ + Λ₂, Λ m = Λ₁m₁ + Λ₂m₂.
TEST(Gaussian, ProductIsTheSumOfInformation) {
  for (std::uint64_t seed = 1; seed < 50; ++seed) {
    using V = Eigen::Matrix<double, 5, 1>;
    const Gaussian<V> a{V::LinSpaced(1, 5), some_covariance<5>(seed)};
    const Gaussian<V> b{V::LinSpaced(-2, 3), some_covariance<5>(seed + 100)};
    const auto c = product(a, b);
    ASSERT_TRUE(c);
    const Matrix<5> la = a.covariance.inverse(), lb = b.covariance.inverse();
    const Matrix<5> sigma = (la + lb).inverse();
    EXPECT_LE((c->covariance - sigma).norm(), 1e-11 * sigma.norm());
    EXPECT_LE((c->mean - sigma * (la * a.mean + lb * b.mean)).norm(), 1e-10);
    expect_covariance(c->covariance);
    // The product of the densities is the product's density up to a constant.
    const V x = V::LinSpaced(0, 1), y = V::LinSpaced(3, -1);
    const auto both = [&](const V& p) { return log_density(a, p) + log_density(b, p); };
    EXPECT_NEAR(both(x) - both(y), log_density(*c, x) - log_density(*c, y), 1e-8);
  }
}

TEST(Gaussian, ProductKeepsAnExactFactorAndWrapsHeadings) {
  // A component that is exact in one factor is exact in the product.
  const Gaussian<SE2d> sure{SE2d(1, 2.0, 179_deg), Eigen::Matrix3d::Zero()};
  const Gaussian<SE2d> vague{SE2d(5, 5.0, -179_deg), Eigen::Matrix3d::Identity()};
  const auto exact = product(sure, vague);
  ASSERT_TRUE(exact);
  EXPECT_LE(exact->mean.minus(sure.mean).norm(), 1e-15);
  EXPECT_EQ(exact->covariance, Eigen::Matrix3d::Zero());
  // Equal weights give the midpoint, across 180° and not across 0°.
  const auto half = product(Gaussian<SE2d>{SE2d(0, 0.0, 170_deg), Eigen::Matrix3d::Identity()},
                            Gaussian<SE2d>{SE2d(0, 0.0, -170_deg), Eigen::Matrix3d::Identity()});
  ASSERT_TRUE(half);
  EXPECT_NEAR(std::abs(half->mean.heading().degrees()), 180.0, 1e-12);
}

TEST(Gaussian, ProductOfSingularCovariancesIsAnError) {
  const Gaussian<SE2d> sure{SE2d(), Eigen::Matrix3d::Zero()};
  const auto result = product(sure, sure);
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().code, ErrorCode::numerical);
  Gaussian<SE2d> broken;
  broken.covariance(1, 1) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(product(broken, Gaussian<SE2d>{}));
}

TEST(Gaussian, SamplesHaveTheMeanAndCovariance) {
  Rng rng(12);
  const Gaussian<Eigen::Vector4d> vector{{1, 2, 3, 4}, some_covariance<4>(2)};
  const Gaussian<SE2d> pose{SE2d(10, -5.0, 170_deg), some_covariance<3>(3, 0.01)};
  const Gaussian<SE3d> body{SE3d::exp(SE3d::Tangent::Constant(0.5)), some_covariance<6>(4, 0.01)};
  std::vector<Eigen::Vector4d> vectors;
  std::vector<SE2d> poses;
  std::vector<SE3d> bodies;
  for (int i = 0; i < 200'000; ++i) {
    vectors.push_back(sample(vector, rng));
    poses.push_back(sample(pose, rng));
    bodies.push_back(sample(body, rng));
  }
  expect_samples_follow(vector, vectors);
  expect_samples_follow(pose, poses);
  expect_samples_follow(body, bodies);
}

TEST(GaussianSampler, SamplesHaveTheMeanAndCovariance) {
  Rng rng(13);
  const Gaussian<SE2d> pose{SE2d(10, -5.0, 170_deg), some_covariance<3>(3, 0.01)};
  const GaussianSampler sampler(pose);
  std::vector<SE2d> poses;
  for (int i = 0; i < 200'000; ++i) poses.push_back(sampler(rng));
  expect_samples_follow(pose, poses);
}

// Of rank one: all samples are on a line through the mean, at a distance of standard deviation |u|.
TEST(GaussianSampler, OfASingularCovariance) {
  const Eigen::Vector3d mean(1, 2, 3), u(0.6, 0.0, -0.8);
  const GaussianSampler sampler(Gaussian<Eigen::Vector3d>{mean, 4.0 * u * u.transpose()});
  Rng rng(14);
  double squares = 0.0;
  constexpr int kCount = 10'000;
  for (int i = 0; i < kCount; ++i) {
    const Eigen::Vector3d off = sampler(rng) - mean;
    ASSERT_LT((off - off.dot(u) * u).norm(), 1e-7);
    squares += off.squaredNorm();
  }
  EXPECT_NEAR(squares / kCount, 4.0, 6.0 * 4.0 * std::sqrt(2.0 / kCount));
}

TEST(Gaussian, SamplesOfASingularCovarianceStayInItsSpan) {
  // A robot that cannot slip sideways.
  Gaussian<SE2d> g{SE2d(), Eigen::Vector3d(0.04, 0.0, 0.01).asDiagonal()};
  Rng rng(13);
  double square = 0.0;
  constexpr int kCount = 100'000;
  for (int i = 0; i < kCount; ++i) {
    const Eigen::Vector3d tau = sample(g, rng).log();
    ASSERT_LE(std::abs(tau.y()), 1e-15);
    square += tau.x() * tau.x();
  }
  EXPECT_NEAR(square / kCount, 0.04, 6.0 * 0.04 * std::sqrt(2.0 / kCount));
}

// First order: the neglected terms are of the order of the squared heading deviation, 0.03², well
// below the tolerance of 0.01.
TEST(Gaussian, ComposeMatchesMonteCarlo) {
  Rng rng(14);
  const double size = 2e-4;
  const Gaussian<SE2d> a{SE2d(3, 1.0, 50_deg), some_covariance<3>(5, size)};
  const Gaussian<SE2d> b{SE2d(2, -1.0, -120_deg), some_covariance<3>(6, size)};
  const Gaussian<SE3d> c{SE3d::exp(SE3d::Tangent::Constant(0.6)), some_covariance<6>(7, size)};
  const Gaussian<SE3d> d{SE3d::exp(SE3d::Tangent::LinSpaced(-1, 1)), some_covariance<6>(8, size)};
  std::vector<SE2d> plane;
  std::vector<SE3d> space;
  for (int i = 0; i < 100'000; ++i) {
    plane.push_back(sample(a, rng) * sample(b, rng));
    space.push_back(sample(c, rng) * sample(d, rng));
  }
  expect_samples_follow(compose(a, b), plane, 6.0, 0.01);
  expect_samples_follow(compose(c, d), space, 6.0, 0.01);
}

TEST(Gaussian, WorksInSinglePrecision) {
  Gaussian<SE2f> g{SE2f(1.0F, 2.0F, BasicAngle<float>::radians(0.5F)),
                   0.01F * Eigen::Matrix3f::Identity()};
  const auto twice = product(g, g);
  ASSERT_TRUE(twice);
  EXPECT_LE((twice->covariance - 0.5F * g.covariance).norm(), 1e-8F);
  EXPECT_NEAR(squared_mahalanobis(g, g.mean.plus({0.1F, 0.0F, 0.0F})), 1.0F, 1e-5F);
  EXPECT_LE((compose(g, g).mean.minus(g.mean * g.mean)).norm(), 1e-6F);
}

}  // namespace
}  // namespace wayfare
