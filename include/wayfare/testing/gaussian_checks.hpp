#pragma once

// Checks on Gaussians and on samples said to come from one. The bounds follow from the number of
// samples, not from what a run happened to give.

#include <cmath>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Cholesky>

#include <wayfare/core/gaussian.hpp>
#include <wayfare/testing/positive_definite.hpp>

namespace wayfare::testing {

/// Finite, symmetric, and no eigenvalue below −`tolerance` times the largest element.
template <class Derived>
void expect_covariance(const Eigen::MatrixBase<Derived>& p, double tolerance = 1e-12) {
  const Eigen::MatrixXd matrix = p.template cast<double>();
  ASSERT_TRUE(matrix.allFinite()) << matrix;
  const double size = matrix.cwiseAbs().maxCoeff();
  EXPECT_LE((matrix - matrix.transpose()).cwiseAbs().maxCoeff(), tolerance * size) << matrix;
  const Eigen::MatrixXd raised =
      matrix + tolerance * size * Eigen::MatrixXd::Identity(matrix.rows(), matrix.cols());
  EXPECT_GT(least_pivot(raised), 0.0) << matrix;
}

/// Tests `samples` against `g` (positive definite) by their first two moments. With z the whitened
/// differences from the mean, n samples of dimension d give
///   mean of z            : variance 1/n each
///   mean of zᵢzⱼ, i ≠ j  : variance 1/n
///   mean of zᵢ²          : variance 2/n about 1
///   mean of zᵀz          : variance 2d/n about d  (the mean normalised error squared)
/// `sigmas` standard deviations are allowed; six pass all but about one in 10⁹ true samples.
/// `curvature` is added to each bound, for samples that are Gaussian to first order only.
template <Manifold M>
void expect_samples_follow(const Gaussian<M>& g, const std::vector<M>& samples, double sigmas = 6.0,
                           double curvature = 0.0) {
  constexpr int kDof = ManifoldTraits<M>::kDof;
  using Vector = Eigen::Matrix<double, kDof, 1>;
  using Square = Eigen::Matrix<double, kDof, kDof>;
  const Eigen::LLT<Square> llt(g.covariance.template cast<double>());
  ASSERT_EQ(llt.info(), Eigen::Success) << "not positive definite:\n" << g.covariance;
  Vector mean = Vector::Zero();
  Square second = Square::Zero();
  for (const M& x : samples) {
    const Vector z =
        llt.matrixL().solve(ManifoldTraits<M>::minus(x, g.mean).template cast<double>());
    mean += z;
    second += z * z.transpose();
  }
  const auto n = static_cast<double>(samples.size());
  mean /= n;
  second /= n;
  const double one = sigmas / std::sqrt(n);
  EXPECT_LE(mean.cwiseAbs().maxCoeff(), one + curvature) << "mean of the whitened samples " << mean;
  const Square excess = second - Square::Identity();
  EXPECT_LE(excess.diagonal().cwiseAbs().maxCoeff(), std::sqrt(2.0) * one + curvature)
      << "variances of the whitened samples\n"
      << second;
  const Square off = excess - Square(excess.diagonal().asDiagonal());
  EXPECT_LE(off.cwiseAbs().maxCoeff(), one + curvature) << "correlations\n" << second;
  EXPECT_LE(std::abs(excess.trace()), std::sqrt(2.0 * kDof) * one + kDof * curvature)
      << "normalised error squared";
}

}  // namespace wayfare::testing
