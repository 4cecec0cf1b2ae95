#pragma once

#include <Eigen/Core>

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

/// The translation's block of information⁻¹, scaled to 1 in its best-known direction: the spread of
/// a pose with this information.
[[nodiscard]] Eigen::Matrix2d spread_of(const Eigen::Matrix3d& information);

/// The match shifted to the motion model's prediction along directions that the scene does not
/// constrain: x = x_match + Σ_match (Σ_match + Σ_motion)⁻¹ (x_motion − x_match).
[[nodiscard]] SE2d settle(const Placement& match, const SE2d& predicted, const Motion& motion);

/// Ω of an edge whose match has `sigma_m` and `sigma_rad`, lower along directions that the scene
/// does not constrain; `rotation` leads from the edge's axes to the map's.
[[nodiscard]] Eigen::Matrix3d match_information(const Placement& match, const SO2d& rotation,
                                                double sigma_m, double sigma_rad);

}  // namespace wayfare::detail
