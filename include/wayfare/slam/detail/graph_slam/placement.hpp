#pragma once

#include <Eigen/Core>
#include <Eigen/Eigenvalues>

#include <wayfare/core/se2.hpp>
#include <wayfare/slam/detail/motion.hpp>

namespace wayfare::detail {

/// Pose of points in a local map, with its uncertainty.
struct Placement {
  SE2d T_map_points;
  double score = 0.0;  ///< agreement in [0, 1]; 0: no match
  /// Covariance of the translation in map axes, as a multiple of the variance in the best-known
  /// direction: near I in a room, long along a corridor.
  Eigen::Matrix2d spread = Eigen::Matrix2d::Identity();
};

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

/// The match shifted to the motion model's prediction along directions that the scene does not
/// constrain: x = x_match + Σ_match (Σ_match + Σ_motion)⁻¹ (x_motion − x_match).
[[nodiscard]] inline SE2d settle(const Placement& match, const SE2d& predicted,
                                 const Motion& motion) {
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

/// Ω of an edge whose match has `sigma_m` and `sigma_rad`, lower along directions that the scene
/// does not constrain; `rotation` leads from the edge's axes to the map's.
[[nodiscard]] inline Eigen::Matrix3d match_information(const Placement& match, const SO2d& rotation,
                                                       double sigma_m, double sigma_rad) {
  const Ambiguity open(match);
  const Eigen::Vector2d variance = open.variance + Eigen::Vector2d::Constant(sigma_m * sigma_m);
  const Eigen::Matrix2d axes = rotation.matrix().transpose() * open.directions;
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  information.topLeftCorner<2, 2>() =
      axes * variance.cwiseInverse().asDiagonal() * axes.transpose();
  information(2, 2) = 1.0 / (sigma_rad * sigma_rad);
  return information;
}

}  // namespace wayfare::detail
