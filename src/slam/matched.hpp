#pragma once

// Matches by a matcher of any type: what it may leave out, and what is refused.

#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include <wayfare/core/gaussian.hpp>
#include <wayfare/match/scan_matcher.hpp>

#include "match/local/registration.hpp"
#include "match/open_direction.hpp"

namespace wayfare {

/// Refuses a match that is not finite, or whose covariance is none.
inline Result<void> check_match(const MatchResult& match) {
  const bool finite = match.T_map_points.translation().allFinite() &&
                      std::isfinite(match.T_map_points.heading().radians()) &&
                      std::isfinite(match.score);
  if (!finite) return Error{ErrorCode::numerical, "the matcher's pose or score is not finite"};
  if (match.covariance && !is_positive_semidefinite(*match.covariance))
    return Error{ErrorCode::numerical,
                 "the matcher's covariance is not finite or not positive semi-definite"};
  return {};
}

/// Zero where the matcher gives none.
[[nodiscard]] inline Eigen::Matrix3d covariance_of(const MatchResult& match) {
  return match.covariance.value_or(Eigen::Matrix3d::Zero());
}

/// By the matcher's constraint, else by its covariance; no direction is open if it gives neither.
[[nodiscard]] inline OpenDirection open_direction(const MatchResult& match,
                                                  const PointSet& points) {
  constexpr double kAllEqual = 0.5;
  const double rms = detail::rms_distance_m(points);
  if (match.constraint) return {*match.constraint, rms};
  SceneConstraint scene;
  scene.share = kAllEqual;
  if (match.covariance && Eigen::LLT<Eigen::Matrix3d>(*match.covariance).info() == Eigen::Success)
    scene = SceneConstraint::of(match.covariance->inverse(), rms);
  return {scene, rms};
}

}  // namespace wayfare
