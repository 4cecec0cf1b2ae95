#include <wayfare/match/detail/scene_constraint.hpp>

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

}  // namespace wayfare
