// Uncertainty of a match.

#include <wayfare/slam/detail/graph_slam/placement.hpp>

#include <algorithm>
#include <cmath>

#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>

#include <wayfare/slam/detail/graph_slam/matcher_matching.hpp>

namespace wayfare::detail {

namespace {

/// Ambiguity of a match along each axis of its spread. σ grows with the cube of the spread, from
/// nothing in a room (1-3) to decimetres in a corridor without doors (7-13), where the few
/// gradients along the walls come from cells and noise.
struct Ambiguity {
  explicit Ambiguity(const Placement& match) {
    constexpr double kSigmaPerCubedSpread_m = 0.0004;
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> eigen(match.spread);
    directions = eigen.eigenvectors();
    variance = (kSigmaPerCubedSpread_m * eigen.eigenvalues().array().cube()).square();
  }

  Eigen::Matrix2d directions;  ///< columns, map axes
  Eigen::Vector2d variance;    ///< m²
};

/// The spread along the direction the scene constrains least: 1 if all are constrained equally,
/// where its share is ½, and the square root of its inverse otherwise.
Eigen::Matrix2d constrained_spread(const SceneConstraint& constraint, const SO2d& heading) {
  constexpr double kLeastShare = 1e-4;
  const double spread = std::sqrt(0.5 / std::clamp(constraint.share, kLeastShare, 0.5));
  const Eigen::Vector2d direction =
      heading.matrix() * Eigen::Vector2d(constraint.weakest.head<2>());
  return Eigen::Matrix2d::Identity() + (spread - 1.0) * direction * direction.transpose();
}

/// The standard deviations of the translation, as multiples of the smallest.
Eigen::Matrix2d covariance_spread(const Eigen::Matrix3d& covariance, const SO2d& heading) {
  constexpr double kLargest = 70.0;
  const Eigen::Matrix2d block = covariance.topLeftCorner<2, 2>();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> eigen(0.5 * (block + block.transpose()));
  const Eigen::Vector2d sigma = eigen.eigenvalues().cwiseMax(1e-12).cwiseSqrt();
  const Eigen::Vector2d spread = (sigma / sigma[0]).cwiseMin(kLargest);
  const Eigen::Matrix2d axes = heading.matrix() * eigen.eigenvectors();
  return axes * spread.asDiagonal() * axes.transpose();
}

}  // namespace

SE2d settle(const Placement& match, const SE2d& predicted, const Motion& motion) {
  const Ambiguity open(match);
  const double motion_variance = motion.sigma[0] * motion.sigma[0];
  const Eigen::Vector2d gain =
      open.variance.cwiseQuotient(open.variance + Eigen::Vector2d::Constant(motion_variance));
  const Eigen::Vector2d gap = predicted.translation() - match.T_map_points.translation();
  const Eigen::Vector2d shift =
      open.directions * gain.asDiagonal() * open.directions.transpose() * gap;
  return SE2d(Eigen::Vector2d(match.T_map_points.translation() + shift),
              match.T_map_points.rotation());
}

Eigen::Matrix3d match_information(const Placement& match, const SO2d& rotation, double sigma_m,
                                  double sigma_rad) {
  const Ambiguity open(match);
  const Eigen::Vector2d variance = open.variance + Eigen::Vector2d::Constant(sigma_m * sigma_m);
  const Eigen::Matrix2d axes = rotation.matrix().transpose() * open.directions;
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  information.topLeftCorner<2, 2>() =
      axes * variance.cwiseInverse().asDiagonal() * axes.transpose();
  information(2, 2) = 1.0 / (sigma_rad * sigma_rad);
  return information;
}

Eigen::Matrix2d spread_of(const Eigen::Matrix3d& information) {
  constexpr double kTiny = 1e-9;
  const double scale = information.topLeftCorner<2, 2>().trace();
  const Eigen::Matrix3d regular =
      information + kTiny * std::max(scale, 1.0) * Eigen::Matrix3d::Identity();
  const Eigen::Matrix2d covariance = regular.inverse().topLeftCorner<2, 2>();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> eigen(covariance, Eigen::EigenvaluesOnly);
  return covariance / std::max(eigen.eigenvalues()[0], 1e-300);
}

Eigen::Matrix2d spread_of(const MatchResult& match) {
  const SO2d& heading = match.T_map_points.rotation();
  if (match.constraint) return constrained_spread(*match.constraint, heading);
  if (match.covariance) return covariance_spread(*match.covariance, heading);
  return Eigen::Matrix2d::Identity();
}

}  // namespace wayfare::detail
