#pragma once

#include <Eigen/Core>

namespace wayfare {

/// How well a scene constrains the pose of a scan in it. Every point constrains the pose along the
/// normal of its surface, with gradient (n, p × n / ρ). ρ is the points' root mean square distance,
/// so that a rotation counts as the motion of a point at that distance. A direction nearly
/// orthogonal to all gradients is unconstrained: the position along a corridor, the heading in a
/// round room.
struct SceneConstraint {
  /// The least constrained direction: (x, y, ρθ) in the matched pose's own axes, a unit vector.
  Eigen::Vector3d weakest = Eigen::Vector3d::UnitZ();
  /// Its share of Σ|n|²: 0 unconstrained, ½ constrained equally in all directions.
  double share = 0.0;
  /// The map's own evidence, nats: the increase of the scan's cost when it is displaced by a
  /// quarter of a metre along `weakest` (or rotated so that the points move as far), on the side
  /// where it is smaller, over points in observed cells at both poses. Unlike normals, it resolves
  /// door frames and sparse beams. Only from Gauss-Newton matching; 0: unknown.
  double displacement_cost_nats = 0.0;

  /// Whether every direction is constrained. The weakest share is above 0.05 in rooms, below 0.01
  /// in bare corridors.
  [[nodiscard]] bool complete(double min_share = 0.02) const { return share >= min_share; }

  /// From Σ g gᵀ over the points, g the gradient with respect to (x, y, θ) in the pose's own axes,
  /// in any unit; zero gradients give a share of zero.
  [[nodiscard]] static SceneConstraint of(const Eigen::Matrix3d& outer_sum, double rms_distance_m);
};

}  // namespace wayfare
