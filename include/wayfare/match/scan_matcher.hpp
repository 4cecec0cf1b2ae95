#pragma once

#include <concepts>
#include <cstdint>
#include <optional>

#include <Eigen/Core>

#include <wayfare/core/angle.hpp>
#include <wayfare/core/result.hpp>
#include <wayfare/core/se2.hpp>
#include <wayfare/map/cell.hpp>
#include <wayfare/match/detail/scene_constraint.hpp>
#include <wayfare/sensors/point_set.hpp>

namespace wayfare {

/// Half extents of the search about the prior pose, along the map's axes. Rounded up to whole
/// cells.
struct SearchWindow {
  double half_x_m = 0.3;
  double half_y_m = 0.3;
  Angle half_heading = Angle::degrees(20);
};

struct MatchOptions {
  /// A match scoring less than this (see MatchResult::score) is none.
  double min_score = 0.0;
  /// Information matrix of a Gaussian prior on (Rᵀ(t − t₀), θ − θ₀), the offset from the prior pose
  /// in its own axes; its log density (without constant) is added to each candidate.
  std::optional<Eigen::Matrix3d> prior_information{};
  /// Neighbouring beams err together: Σ ln p is scaled as if only this many points were
  /// independent, against the prior and in the covariance. 0: every point counts.
  double independent_points = 0.0;
  /// Whether to compute the covariance and what the scene constrains (slower where it takes every
  /// candidate's score).
  bool covariance = false;
};

/// A candidate: the prior moved by whole cells along the map's axes and by whole heading steps.
struct Candidate {
  Cell offset;
  int heading_step = 0;
  auto operator<=>(const Candidate&) const = default;
};

struct MatchResult {
  SE2d T_map_points;
  /// (1/N) Σ ln p(point | map), nats.
  double mean_log_likelihood = 0.0;
  /// The same between 0 (every point at the map's floor) and 1 (every point at probability 1).
  double score = 0.0;
  /// The candidate, and how many the search stood for; matchers that climb have none.
  Candidate candidate;
  std::int64_t candidates = 0;
  /// Of (x, y, θ) in the matched pose's own axes, never wider than the window: what the scores'
  /// distribution over the window says (Olson 2009), or the inverse of the information at the
  /// match.
  std::optional<Eigen::Matrix3d> covariance;
  /// Given with the covariance.
  std::optional<SceneConstraint> constraint;
};

/// Finds the pose of points in a map near a prior: none where nothing in the window reaches the
/// minimum score, an Error for input no search can be made for (no points, NaN, a window beyond all
/// measure).
template <class M>
concept ScanMatcher = requires(M matcher, const typename M::Map& map, const PointSet& points,
                               const SE2d& prior, const SearchWindow& window,
                               const MatchOptions& options) {
  {
    matcher.match(map, points, prior, window, options)
    } -> std::same_as<Result<std::optional<MatchResult>>>;
};

}  // namespace wayfare
