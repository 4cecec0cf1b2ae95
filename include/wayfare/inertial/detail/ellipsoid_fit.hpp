#pragma once

// The ellipsoid |M·(x − c)| = 1 through points, M symmetric and positive definite.

#include <optional>
#include <span>

#include <Eigen/Core>

namespace wayfare {

struct Ellipsoid {
  using Covariance = Eigen::Matrix<double, 9, 9>;

  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  Eigen::Matrix3d matrix = Eigen::Matrix3d::Identity();
  /// Order: centre, then M's elements 00, 11, 22, 01, 02, 12.
  Covariance covariance = Covariance::Zero();
  double residual = 0.0;  ///< robust standard deviation of |M·(x − c)|
};

/// Minimises the distances to the surface by Gauss-Newton with Huber weights, starting from the
/// algebraic fit (or a sphere); points of any position and scale. None if the points do not
/// determine it.
[[nodiscard]] std::optional<Ellipsoid> fit_ellipsoid(std::span<const Eigen::Vector3d> points);

}  // namespace wayfare
