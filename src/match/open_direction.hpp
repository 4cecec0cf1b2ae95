#pragma once

#include <Eigen/Core>

#include <wayfare/match/scan_matcher.hpp>

namespace wayfare {

/// The unconstrained direction of a match. Points beyond the observed part of a bare corridor bias
/// the match back along it, so the match is ignored in this direction.
class OpenDirection {
 public:
  /// Of a match with its points' root mean square distance.
  OpenDirection(const SceneConstraint& scene, double rms_distance_m);

  [[nodiscard]] double openness() const { return openness_; }
  /// The match, with its component along the open direction replaced by the expected one.
  [[nodiscard]] SE2d settle(const SE2d& matched, const SE2d& expected) const;
  /// The match's covariance, widened by `by_m` (σ) along the open direction.
  [[nodiscard]] Eigen::Matrix3d widen(const Eigen::Matrix3d& covariance, double by_m = 1.0) const;

 private:
  double openness_;            // 0: constrained, 1: unconstrained
  Eigen::Vector3d direction_;  // in (x, y, ρθ), a unit vector
  Eigen::Vector3d scale_;      // (1, 1, ρ)
};

}  // namespace wayfare
