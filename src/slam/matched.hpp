#pragma once

// Matches by a matcher of any type: what it may leave out, and what is refused.

#include <cmath>
#include <optional>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include <wayfare/match/scan_matcher.hpp>
#include <wayfare/slam/detail/check_match.hpp>
#include <wayfare/slam/detail/matched_map.hpp>
#include <wayfare/slam/scan_outcome.hpp>

#include "match/local/registration.hpp"
#include "match/open_direction.hpp"

namespace wayfare {

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

/// A match in or about the window; none where the matcher returns an Error, which is added to
/// `errors`. An Error if the match is not valid.
[[nodiscard]] inline Result<std::optional<MatchResult>> match_in(
    detail::MatchedMap& map, const PointSet& points, const SE2d& prior, const SearchWindow& window,
    const MatchOptions& options, MatcherErrors& errors) {
  auto found = map.match(points, prior, window, options);
  if (!found) errors.add(found.error());
  if (!found || !*found) return std::optional<MatchResult>();
  if (auto ok = detail::check_match(**found); !ok) return ok.error();
  if (!is_within_reach(**found, prior, window)) return std::optional<MatchResult>();
  return found;
}

/// Zero where the matcher gives none.
[[nodiscard]] inline Eigen::Matrix3d covariance_of(const MatchResult& match) {
  return match.covariance.value_or(Eigen::Matrix3d::Zero());
}

/// What of a match's covariance stays in the map: errors of single scans average out, that along a
/// direction which the scene leaves open does not.
[[nodiscard]] inline Eigen::Matrix3d lasting_covariance(const Eigen::Matrix3d& matched) {
  constexpr double kOpen_m = 0.1;
  const bool is_open = matched.topLeftCorner<2, 2>().trace() > kOpen_m * kOpen_m;
  return is_open ? matched : Eigen::Matrix3d(Eigen::Matrix3d::Zero());
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
