#include "open_direction.hpp"

#include <algorithm>

namespace wayfare {

OpenDirection::OpenDirection(const SceneConstraint& scene, double rms_distance_m)
    : direction_(scene.weakest), scale_(1, 1, std::max(rms_distance_m, 0.1)) {
  constexpr double kBare = 0.005, kRoom = 0.02;  // shares of the weakest direction
  openness_ = std::clamp((kRoom - scene.share) / (kRoom - kBare), 0.0, 1.0);
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
