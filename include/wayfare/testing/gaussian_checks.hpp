#pragma once

// Checks on Gaussians and on samples drawn from one. The bounds follow from the number of samples,
// not from the results of a particular run.

#include <cmath>
#include <cstddef>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Cholesky>

#include <wayfare/core/gaussian.hpp>
#include <wayfare/testing/detail/positive_definite.hpp>

namespace wayfare::testing {

/// Finite, symmetric, and no eigenvalue below −`tolerance` times the largest element.
inline void expect_covariance(const Eigen::MatrixXd& matrix, double tolerance = 1e-12) {
  ASSERT_TRUE(matrix.allFinite()) << matrix;
  const double size = matrix.cwiseAbs().maxCoeff();
  EXPECT_LE((matrix - matrix.transpose()).cwiseAbs().maxCoeff(), tolerance * size) << matrix;
  const Eigen::MatrixXd raised =
      matrix + tolerance * size * Eigen::MatrixXd::Identity(matrix.rows(), matrix.cols());
  EXPECT_GT(least_pivot(raised), 0.0) << matrix;
}

/// As expect_samples_follow below; `differences`: sample ⊖ mean, one column each.
inline void expect_differences_follow(const Eigen::MatrixXd& covariance,
                                      const Eigen::MatrixXd& differences, double sigmas,
                                      double curvature) {
  const Eigen::LLT<Eigen::MatrixXd> llt(covariance);
  ASSERT_EQ(llt.info(), Eigen::Success) << "not positive definite:\n" << covariance;
  const Eigen::MatrixXd z = llt.matrixL().solve(differences);
  const auto n = static_cast<double>(z.cols());
  const auto dof = static_cast<double>(z.rows());
  const Eigen::VectorXd mean = z.rowwise().mean();
  const Eigen::MatrixXd second = z * z.transpose() / n;
  const double one = sigmas / std::sqrt(n);
  EXPECT_LE(mean.cwiseAbs().maxCoeff(), one + curvature) << "mean of the whitened samples " << mean;
  Eigen::MatrixXd excess = second;
  excess.diagonal().array() -= 1.0;
  EXPECT_LE(std::abs(excess.trace()), std::sqrt(2.0 * dof) * one + dof * curvature)
      << "normalised error squared";
  EXPECT_LE(excess.diagonal().cwiseAbs().maxCoeff(), std::sqrt(2.0) * one + curvature)
      << "variances of the whitened samples\n"
      << second;
  excess.diagonal().setZero();
  EXPECT_LE(excess.cwiseAbs().maxCoeff(), one + curvature) << "correlations\n" << second;
}

/// Tests `samples` against `g` (positive definite) by their first two moments. With z the whitened
/// differences from the mean, n samples of dimension d give
///   mean of z            : variance 1/n each
///   mean of zᵢzⱼ, i ≠ j  : variance 1/n
///   mean of zᵢ²          : variance 2/n about 1
///   mean of zᵀz          : variance 2d/n about d  (the mean normalised error squared)
/// `sigmas` standard deviations are allowed; six fail about one in 10⁹ valid sample sets.
/// `curvature` is added to each bound, for samples that are Gaussian to first order only.
template <Manifold M>
void expect_samples_follow(const Gaussian<M>& g, const std::vector<M>& samples, double sigmas = 6.0,
                           double curvature = 0.0) {
  Eigen::MatrixXd differences(ManifoldTraits<M>::kDof, static_cast<Eigen::Index>(samples.size()));
  for (Eigen::Index i = 0; i < differences.cols(); ++i) {
    const auto d = ManifoldTraits<M>::minus(samples[static_cast<std::size_t>(i)], g.mean);
    for (int k = 0; k < ManifoldTraits<M>::kDof; ++k) differences(k, i) = d[k];
  }
  expect_differences_follow(g.covariance.template cast<double>(), differences, sigmas, curvature);
}

}  // namespace wayfare::testing
