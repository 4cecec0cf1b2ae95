#pragma once

#include <Eigen/Core>

#include <wayfare/match/scan_matcher.hpp>

namespace wayfare {

/// The direction of a match that its scene says nothing about: points beyond the edge of what is
/// known pull a robot back along a bare corridor, so there the match is not believed.
class OpenDirection {
 public:
  /// Of a match with covariance, of points at this root mean square distance.
  OpenDirection(const SceneConstraint& scene, double rms_distance_m);

  [[nodiscard]] double openness() const { return openness_; }
  /// The match, moved to where motion led along the open direction.
  [[nodiscard]] SE2d settle(const SE2d& matched, const SE2d& expected) const;
  /// The match's covariance, so much wider along the open direction.
  [[nodiscard]] Eigen::Matrix3d widen(const Eigen::Matrix3d& covariance, double by_m = 1.0) const;

 private:
  double openness_;            // 0: the scene holds it, 1: not at all
  Eigen::Vector3d direction_;  // in (x, y, ρθ), a unit vector
  Eigen::Vector3d scale_;      // (1, 1, ρ)
};

}  // namespace wayfare
