#pragma once

#include <Eigen/Core>

namespace wayfare {

/// What a scene says about the pose of a scan in it. Every point pulls along the normal of what it
/// is matched with: its gradient is (n, p × n / ρ), with ρ the points' root mean square distance,
/// so that turning by an angle counts as moving a point that far out. A direction of the pose to
/// which all gradients are nearly square is left open: the way along a corridor, the heading in a
/// round room.
struct SceneConstraint {
  /// The least constrained direction: (x, y, ρθ) in the matched pose's own axes, a unit vector.
  Eigen::Vector3d weakest = Eigen::Vector3d::UnitZ();
  /// Its share of Σ|n|²: 0 says nothing about it, ½ is a wall for a wall.
  double share = 0.0;
  /// What the map itself says of it, nats: how much worse the scan fits a quarter of a metre along
  /// it (turned so far that the points move as much), on the side where it fits better, by points
  /// that fall into cells seen before at both places. Normals smooth over door frames and are few
  /// where beams are; the map is not. Found by Gauss-Newton matching alone; 0: nothing is known.
  double held_nats = 0.0;

  /// Whether every direction is constrained. In rooms the weakest share is above 0.05, in bare
  /// corridors below 0.01.
  [[nodiscard]] bool complete(double least_share = 0.02) const { return share >= least_share; }

  /// From Σ g gᵀ over the points, g the gradient with respect to (x, y, θ) in the pose's own axes,
  /// of any unit; zero gradients give a share of zero.
  [[nodiscard]] static SceneConstraint of(const Eigen::Matrix3d& outer_sum, double rms_distance_m);
};

}  // namespace wayfare
