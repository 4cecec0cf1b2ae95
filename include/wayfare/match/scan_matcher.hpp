#pragma once

// What a scan matcher is: its window, options, result and concepts.

#include <concepts>
#include <cstdint>
#include <optional>
#include <span>

#include <Eigen/Core>

#include <wayfare/core/angle.hpp>
#include <wayfare/core/result.hpp>
#include <wayfare/core/se2.hpp>
#include <wayfare/map/cell.hpp>
#include <wayfare/map/likelihood_field.hpp>
#include <wayfare/match/detail/scene_constraint.hpp>
#include <wayfare/sensors/point_set.hpp>

namespace wayfare {

/// Half extents of the search about the prior pose, along the map's axes. Rounded up to whole
/// cells.
struct SearchWindow {
  double half_x_m = 0.3;                    ///< along the map's x
  double half_y_m = 0.3;                    ///< along the map's y
  Angle half_heading = Angle::degrees(20);  ///< to either side of the prior's
};

/// What a match must reach, its prior and whether its covariance is wanted.
struct MatchOptions {
  /// Matches with a smaller score (see MatchResult::score) are rejected.
  double min_score = 0.0;
  /// Information matrix of a Gaussian prior on (Rᵀ(t − t₀), θ − θ₀), the offset from the prior pose
  /// in its own axes; its log density (without constant) is added to each candidate. Positive
  /// semi-definite; zero is no prior.
  std::optional<Eigen::Matrix3d> prior_information{};
  /// Errors of neighbouring beams are correlated: Σ ln p is scaled to this number of independent
  /// points, relative to the prior and in the covariance. 0: all points are independent.
  double independent_points = 0.0;
  /// Whether to compute the covariance and the scene constraint (slower for matchers that need
  /// every candidate's score).
  bool covariance = false;
};

/// A candidate: the prior moved by whole cells along the map's axes and by whole heading steps.
struct Candidate {
  Cell offset;           ///< cells from the prior
  int heading_step = 0;  ///< steps from the prior's heading
  /// By offset, then by heading.
  auto operator<=>(const Candidate&) const = default;
};

/// The best pose of a match and how well it fits.
struct MatchResult {
  SE2d T_map_points{};  ///< pose of the points' frame in the map
  /// (1/N) Σ ln p(point | map), nats.
  double mean_log_likelihood = 0.0;
  /// The same, scaled to 0 (every point at the map's floor) … 1 (every point at probability 1).
  double score = 0.0;
  /// The candidate and the number searched; zero for iterative matchers.
  Candidate candidate{};
  std::int64_t candidates = 0;  ///< see `candidate`
  /// Of (x, y, θ) in the matched pose's own axes, never wider than the window: from the scores'
  /// distribution over the window (Olson 2009), or the inverse of the information at the match.
  std::optional<Eigen::Matrix3d> covariance{};
  /// Given with the covariance.
  std::optional<SceneConstraint> constraint{};
};

/// Finds the pose of points in a map near a prior. No result if nothing in the window reaches the
/// minimum score; an Error for invalid input (an empty map, no points, NaN, a window that is too
/// large, an indefinite prior information, options out of range).
template <class M>
concept ScanMatcher = requires(M matcher, const typename M::Map& map, const PointSet& points,
                               const SE2d& prior, const SearchWindow& window,
                               const MatchOptions& options) {
  {
    matcher.match(map, points, prior, window, options)
    } -> std::same_as<Result<std::optional<MatchResult>>>;
};

/// A matcher that makes its maps of placed scans, as the SLAM systems need. An Error of `make_map`
/// (no points, a map that is too large) means that nothing matches there.
template <class M>
concept MappingMatcher = ScanMatcher<M> && std::copy_constructible<M> &&
    requires(M matcher, std::span<const PlacedPoints> scans) {
  { matcher.make_map(scans) } -> std::same_as<Result<typename M::Map>>;
};

}  // namespace wayfare
