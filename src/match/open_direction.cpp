#include "match/open_direction.hpp"

#include <algorithm>

#include <Eigen/Eigenvalues>

namespace wayfare {

SceneConstraint SceneConstraint::of(const Eigen::Matrix3d& outer_sum, double rms_distance_m) {
  SceneConstraint c;
  const double total = outer_sum(0, 0) + outer_sum(1, 1);
  if (!(total > 0) || !(rms_distance_m > 0) || !outer_sum.allFinite()) return c;
  const Eigen::Vector3d scale(1, 1, 1 / rms_distance_m);
  const Eigen::Matrix3d shares = scale.asDiagonal() * outer_sum * scale.asDiagonal() / total;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(shares);
  c.weakest = eigen.eigenvectors().col(0);
  c.share = std::max(0.0, eigen.eigenvalues()[0]);
  return c;
}

OpenDirection::OpenDirection(const SceneConstraint& scene, double rms_distance_m)
    : direction_(scene.weakest), scale_(1, 1, std::max(rms_distance_m, 0.1)) {
  // In bare corridors one to two centimetres of noise rotate normals by 1° to 2°, and a
  // displacement costs less than one nat in nine of ten scans.
  constexpr double kBare = 0.001, kRoom = 0.004;     // shares of the weakest direction
  constexpr double kOpen = 1.0, kConstrained = 2.5;  // nats
  const auto below = [](double value, double low, double high) {
    return std::clamp((high - value) / (high - low), 0.0, 1.0);
  };
  openness_ =
      below(scene.share, kBare, kRoom) * below(scene.displacement_cost_nats, kOpen, kConstrained);
}

SE2d OpenDirection::settle(const SE2d& matched, const SE2d& expected) const {
  const Eigen::Vector3d gap = expected.minus(matched).cwiseProduct(scale_);
  const Eigen::Vector3d move = openness_ * direction_.dot(gap) * direction_;
  return matched.plus(Eigen::Vector3d(move.cwiseQuotient(scale_)));
}

Eigen::Matrix3d OpenDirection::widen(const Eigen::Matrix3d& covariance, double by_m) const {
  const Eigen::Vector3d u = direction_.cwiseQuotient(scale_);
  return covariance + by_m * by_m * openness_ * u * u.transpose();
}

}  // namespace wayfare
