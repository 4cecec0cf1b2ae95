#pragma once

// Matches by a matcher of any type: what it may leave out, and what is refused.

#include <cmath>
#include <optional>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include <wayfare/core/gaussian.hpp>
#include <wayfare/match/scan_matcher.hpp>
#include <wayfare/slam/detail/matched_map.hpp>

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

/// Whether a match is within twice the window, and what it may be rounded up by: a matcher that
/// does not keep to it may find another place.
[[nodiscard]] inline bool is_within_reach(const MatchResult& match, const SE2d& prior,
                                          const SearchWindow& window) {
  constexpr double kRounding_m = 0.1, kRounding_rad = 0.05;
  const SE2d& found = match.T_map_points;
  const Eigen::Vector2d d = (found.translation() - prior.translation()).cwiseAbs();
  const double turn = (prior.rotation().inverse() * found.rotation()).angle().radians();
  return d.x() <= 2 * window.half_x_m + kRounding_m && d.y() <= 2 * window.half_y_m + kRounding_m &&
         std::abs(turn) <= 2 * window.half_heading.radians() + kRounding_rad;
}

/// A valid match in or about the window; none where the matcher returns an Error.
[[nodiscard]] inline Result<std::optional<MatchResult>> match_in(detail::MatchedMap& map,
                                                                 const PointSet& points,
                                                                 const SE2d& prior,
                                                                 const SearchWindow& window,
                                                                 const MatchOptions& options) {
  auto found = map.match(points, prior, window, options);
  if (!found || !*found) return std::optional<MatchResult>();
  if (auto ok = check_match(**found); !ok) return ok.error();
  if (!is_within_reach(**found, prior, window)) return std::optional<MatchResult>();
  return found;
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
