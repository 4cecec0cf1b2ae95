#pragma once

#include <Eigen/Core>

#include <wayfare/core/se2.hpp>

#include "slam/graph_slam/local_map.hpp"
#include "slam/motion.hpp"

namespace wayfare {

/// Ambiguity of a match along each axis of its spread.
struct Ambiguity {
  explicit Ambiguity(const Placement& match);

  Eigen::Matrix2d directions;  ///< columns, map axes
  Eigen::Vector2d variance;    ///< m²
};

/// The match shifted to the motion model's prediction along directions that the scene does not
/// constrain: x = x_match + Σ_match (Σ_match + Σ_motion)⁻¹ (x_motion − x_match).
[[nodiscard]] SE2d settle(const Placement& match, const SE2d& predicted, const Motion& motion);

/// Ω of an edge whose match has `sigma_m` and `sigma_rad`, lower along directions that the scene
/// does not constrain; `rotation` leads from the edge's axes to the map's.
[[nodiscard]] Eigen::Matrix3d match_information(const Placement& match, const SO2d& rotation,
                                                double sigma_m, double sigma_rad);

}  // namespace wayfare
