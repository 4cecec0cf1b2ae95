#include <wayfare/inertial/detail/ellipsoid_fit.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/QR>

#include <wayfare/core/statistics.hpp>

namespace wayfare {
namespace {

using Row = Eigen::Matrix<double, 9, 1>;
using Points = std::span<const Eigen::Vector3d>;

/// Linear least squares of the quadric xᵀQx + 2gᵀx = 1; none if it is not an ellipsoid. The points
/// must surround the origin.
std::optional<Ellipsoid> algebraic_fit(Points points) {
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
  const Eigen::Matrix3d root =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(form / level).operatorSqrt();
  e.matrix = 0.5 * (root + root.transpose());  // symmetric but for rounding
  return e;
}

/// Signed distance of `p` from the surface relative to the radius, and its Jacobian.
double distance(const Ellipsoid& e, const Eigen::Vector3d& p, Row& jacobian) {
  const Eigen::Vector3d d = p - e.centre, image = e.matrix * d;
  const double norm = std::max(image.norm(), std::numeric_limits<double>::min());
  const Eigen::Vector3d u = image / norm;
  jacobian << -e.matrix * u, u.x() * d.x(), u.y() * d.y(), u.z() * d.z(),
      u.x() * d.y() + u.y() * d.x(), u.x() * d.z() + u.z() * d.x(), u.y() * d.z() + u.z() * d.y();
  return norm - 1.0;
}

void move(Ellipsoid& e, const Row& step) {
  e.centre += step.head<3>();
  Eigen::Matrix3d change;
  change << step[3], step[6], step[7], step[6], step[4], step[8], step[7], step[8], step[5];
  e.matrix += change;
}

/// The points relative to their mean, scaled to a largest norm of one.
struct Scaled {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  double scale = 0.0;
  std::vector<Eigen::Vector3d> points;

  explicit Scaled(Points raw) : points(raw.begin(), raw.end()) {
    for (const auto& p : points) mean += p / static_cast<double>(points.size());
    for (auto& p : points) scale = std::max(scale, (p -= mean).norm());
    if (usable())
      for (auto& p : points) p /= scale;
  }
  [[nodiscard]] bool usable() const { return scale > 0.0 && std::isfinite(scale); }
};

struct Equations {
  Ellipsoid::Covariance information = Ellipsoid::Covariance::Zero();
  Row gradient = Row::Zero();
};

/// With Huber weights of threshold 1.5 `e.residual`.
Equations linearise(const Ellipsoid& e, Points points) {
  Equations equations;
  const double threshold = std::max(1.5 * e.residual, 1e-12);
  Row jacobian;
  for (const auto& p : points) {
    const double r = distance(e, p, jacobian);
    const double weight = std::min(1.0, threshold / std::max(std::abs(r), threshold));
    equations.information += weight * jacobian * jacobian.transpose();
    equations.gradient += weight * r * jacobian;
  }
  return equations;
}

/// Robust standard deviation: 1.4826 times the median magnitude.
double residual_of(const Ellipsoid& e, Points points) {
  std::vector<double> magnitudes;
  magnitudes.reserve(points.size());
  Row jacobian;
  for (const auto& p : points) magnitudes.push_back(std::abs(distance(e, p, jacobian)));
  return 1.4826 * upper_median_of(magnitudes);
}

/// Gauss-Newton on `e`: the final information matrix, none if it diverges.
std::optional<Ellipsoid::Covariance> refine(Ellipsoid& e, Points points) {
  Equations equations;
  for (int iteration = 0; iteration < 50; ++iteration) {
    e.residual = residual_of(e, points);
    equations = linearise(e, points);
    const Row step = -equations.information.ldlt().solve(equations.gradient);
    if (!step.allFinite() || step.norm() > 1e3) return std::nullopt;
    // A step of more than half the size could invert the ellipsoid.
    move(e, step * std::min(1.0, 0.5 / step.norm()));
    if (step.norm() < 1e-10) break;
  }
  return equations.information;
}

bool determined(const Ellipsoid& e, const Ellipsoid::Covariance& information) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> spectrum(information,
                                                                Eigen::EigenvaluesOnly);
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(e.matrix);
  return spectrum.eigenvalues()[0] > 1e-9 * spectrum.eigenvalues()[8] &&
         axes.eigenvalues()[0] > 0.0;
}

}  // namespace

std::optional<Ellipsoid> fit_ellipsoid(Points points) {
  if (points.size() < 9) return std::nullopt;
  const Scaled scaled(points);
  if (!scaled.usable()) return std::nullopt;
  Ellipsoid e = algebraic_fit(scaled.points).value_or(Ellipsoid{});
  const auto information = refine(e, scaled.points);
  if (!information || !determined(e, *information)) return std::nullopt;

  Row units;
  units << Eigen::Vector3d::Constant(scaled.scale),
      Eigen::Matrix<double, 6, 1>::Constant(1.0 / scaled.scale);
  e.covariance = units.asDiagonal() * (e.residual * e.residual * information->inverse()).eval() *
                 units.asDiagonal();
  e.centre = scaled.mean + scaled.scale * e.centre;
  e.matrix /= scaled.scale;
  return e;
}

}  // namespace wayfare
