#pragma once

// The ellipsoid |M·(x − c)| = 1 through points, M symmetric and positive definite.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <Eigen/QR>

namespace wayfare {

struct Ellipsoid {
  using Covariance = Eigen::Matrix<double, 9, 9>;

  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  Eigen::Matrix3d matrix = Eigen::Matrix3d::Identity();
  /// Of the centre, then of M's elements 00, 11, 22, 01, 02, 12.
  Covariance covariance = Covariance::Zero();
  double residual = 0.0;  ///< robust standard deviation of |M·(x − c)|
};

namespace ellipsoid {

using Row = Eigen::Matrix<double, 9, 1>;
using Points = std::span<const Eigen::Vector3d>;

/// Least squares of the quadric xᵀQx + 2gᵀx = 1, which is linear; nothing where it is no ellipsoid.
/// The points must lie around the origin.
[[nodiscard]] inline std::optional<Ellipsoid> algebraic_fit(Points points) {
  Eigen::MatrixXd a(static_cast<Eigen::Index>(points.size()), 9);
  Eigen::Index i = 0;
  for (const Eigen::Vector3d& p : points) {
    a.row(i++) << p.x() * p.x(), p.y() * p.y(), p.z() * p.z(), 2 * p.x() * p.y(), 2 * p.x() * p.z(),
        2 * p.y() * p.z(), 2 * p.x(), 2 * p.y(), 2 * p.z();
  }
  const Row q = a.colPivHouseholderQr().solve(Eigen::VectorXd::Ones(a.rows()));
  Eigen::Matrix3d form;
  form << q[0], q[3], q[4], q[3], q[1], q[5], q[4], q[5], q[2];
  const Eigen::LLT<Eigen::Matrix3d> factor(form);
  if (factor.info() != Eigen::Success) return std::nullopt;
  Ellipsoid e;
  e.centre = -factor.solve(q.tail<3>());
  const double level = 1.0 - q.tail<3>().dot(e.centre);
  if (!(level > 0.0)) return std::nullopt;
  e.matrix = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(form / level).operatorSqrt();
  return e;
}

/// How far `p` is outside in terms of the radius, and by what that changes with the parameters.
[[nodiscard]] inline double distance(const Ellipsoid& e, const Eigen::Vector3d& p, Row& jacobian) {
  const Eigen::Vector3d d = p - e.centre, image = e.matrix * d;
  const double norm = std::max(image.norm(), std::numeric_limits<double>::min());
  const Eigen::Vector3d u = image / norm;
  jacobian << -e.matrix * u, u.x() * d.x(), u.y() * d.y(), u.z() * d.z(),
      u.x() * d.y() + u.y() * d.x(), u.x() * d.z() + u.z() * d.x(), u.y() * d.z() + u.z() * d.y();
  return norm - 1.0;
}

inline void move(Ellipsoid& e, const Row& step) {
  e.centre += step.head<3>();
  Eigen::Matrix3d change;
  change << step[3], step[6], step[7], step[6], step[4], step[8], step[7], step[8], step[5];
  e.matrix += change;
}

/// Standard deviation of the middle half, as of a normal distribution.
[[nodiscard]] inline double spread_of(std::vector<double> magnitudes) {
  const auto middle = magnitudes.begin() + static_cast<std::ptrdiff_t>(magnitudes.size() / 2);
  std::nth_element(magnitudes.begin(), middle, magnitudes.end());
  return 1.4826 * *middle;
}

}  // namespace ellipsoid

/// Least distance to the surface by Gauss-Newton with Huber's weights from the algebraic fit (or a
/// sphere), points in any position and scale. Nothing where the points do not determine it.
[[nodiscard]] inline std::optional<Ellipsoid> fit_ellipsoid(
    std::span<const Eigen::Vector3d> points) {
  using ellipsoid::Row;
  if (points.size() < 9) return std::nullopt;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const auto& p : points) mean += p / static_cast<double>(points.size());
  double scale = 0.0;
  std::vector<Eigen::Vector3d> scaled(points.begin(), points.end());
  for (auto& p : scaled) scale = std::max(scale, (p -= mean).norm());
  if (!(scale > 0.0) || !std::isfinite(scale)) return std::nullopt;
  for (auto& p : scaled) p /= scale;

  Ellipsoid e = ellipsoid::algebraic_fit(scaled).value_or(Ellipsoid{});
  std::vector<double> magnitudes(scaled.size());
  Ellipsoid::Covariance information;
  for (int round = 0; round < 50; ++round) {
    Row jacobian, gradient = Row::Zero();
    for (std::size_t i = 0; i < scaled.size(); ++i)
      magnitudes[i] = std::abs(ellipsoid::distance(e, scaled[i], jacobian));
    e.residual = ellipsoid::spread_of(magnitudes);
    const double bend = std::max(1.5 * e.residual, 1e-12);
    information.setZero();
    for (const auto& p : scaled) {
      const double r = ellipsoid::distance(e, p, jacobian);
      const double weight = std::min(1.0, bend / std::max(std::abs(r), bend));
      information += weight * jacobian * jacobian.transpose();
      gradient += weight * r * jacobian;
    }
    const Row step = -information.ldlt().solve(gradient);
    if (!step.allFinite() || step.norm() > 1e3) return std::nullopt;
    // A step of more than half the size would turn the ellipsoid inside out.
    ellipsoid::move(e, step * std::min(1.0, 0.5 / step.norm()));
    if (step.norm() < 1e-10) break;
  }
  const Eigen::SelfAdjointEigenSolver<Ellipsoid::Covariance> spectrum(information);
  const auto& eigenvalues = spectrum.eigenvalues();
  if (!(eigenvalues[0] > 1e-9 * eigenvalues[8])) return std::nullopt;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(e.matrix);
  if (!(axes.eigenvalues()[0] > 0.0)) return std::nullopt;

  Row units;
  units << Eigen::Vector3d::Constant(scale), Eigen::Matrix<double, 6, 1>::Constant(1.0 / scale);
  e.covariance = units.asDiagonal() * (e.residual * e.residual * information.inverse()).eval() *
                 units.asDiagonal();
  e.centre = mean + scale * e.centre;
  e.matrix /= scale;
  return e;
}

}  // namespace wayfare
