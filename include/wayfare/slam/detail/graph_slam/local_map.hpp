#pragma once

#include <algorithm>
#include <optional>
#include <span>

#include <Eigen/Core>

#include <wayfare/map/detail/precomputation_grids.hpp>
#include <wayfare/map/likelihood_field.hpp>
#include <wayfare/match/correlative.hpp>
#include <wayfare/match/gauss_newton.hpp>
#include <wayfare/slam/detail/graph_slam/placement.hpp>

namespace wayfare::detail {

/// A likelihood field of some scans, with matchers for another scan. One per thread.
class LocalMap {
 public:
  /// Nothing matches if the scans make no field (none, or extending too far).
  void render(std::span<const PlacedPoints> scans, double cell_m, double sigma_m) {
    // A point counts as an outlier from 1.8 σ, so that moved or previously occluded objects do not
    // attract it.
    constexpr double kOutlierProbability = 0.2;
    pyramid_.reset();
    (void)maker_.make(scans, {cell_m, sigma_m, kOutlierProbability}, grid_);
  }

  /// Exhaustive search of a small window, to one cell and one heading step.
  [[nodiscard]] Placement search(const PointSet& points, const SE2d& prior,
                                 const SearchWindow& window,
                                 const std::optional<Eigen::Matrix3d>& prior_information = {}) {
    MatchOptions options;
    options.prior_information = prior_information;
    options.independent_points = kIndependentPoints;
    return placement(near_.match(grid_, points, prior, window, options), prior);
  }

  /// The same for a large window by branch and bound, for scores of at least `min_score`. The first
  /// call after `render` is slower: it computes the precomputation grids.
  [[nodiscard]] Placement search_far(const PointSet& points, const SE2d& prior,
                                     const SearchWindow& window, double min_score,
                                     const std::optional<Eigen::Matrix3d>& prior_information = {}) {
    MatchOptions options;
    options.min_score = min_score;
    options.prior_information = prior_information;
    if (prior_information) options.independent_points = kIndependentPoints;
    if (!pyramid_) pyramid_.emplace(grid_);
    return placement(far_.match(*pyramid_, points, prior, window, options), prior);
  }

  /// Between the cells about a pose that was found. Near it: in a corridor the rest of the map
  /// would draw the pose along the walls.
  [[nodiscard]] SE2d between_cells(const PointSet& points, const SE2d& found) const {
    const double sigma_m = 0.5 * grid_.resolution_m();
    constexpr double kSigma_rad = 0.01;
    RefineOptions options;
    options.prior = {found, information_of({sigma_m, sigma_m, kSigma_rad}), kIndependentPoints};
    const auto fine = wayfare::refine(grid_, points, found, options);
    return fine ? fine->T_map_points : found;
  }

  /// Refinement between cells; only this estimates the spread.
  [[nodiscard]] Placement refine(const PointSet& points, const SE2d& start) const {
    const auto fine = wayfare::refine(grid_, points, start);
    if (!fine) return {start};
    // The information is in the pose's own axes, the spread in the map's.
    const Eigen::Matrix2d r = fine->T_map_points.rotation().matrix();
    return {fine->T_map_points, fine->score, r * spread_of(fine->information) * r.transpose()};
  }

  /// The log likelihood of a score of 1 relative to that of 0, nats.
  [[nodiscard]] double score_weight() const { return -kIndependentPoints * grid_.log_floor(); }

 private:
  /// Errors of a scan's points are correlated, and in a corridor those beyond the mapped area bias
  /// the pose.
  static constexpr double kIndependentPoints = 8.0;

  /// The match, if any; else the prior with a score of 0.
  static Placement placement(const Result<std::optional<MatchResult>>& match, const SE2d& prior) {
    if (!match || !*match) return {prior};
    return {(*match)->T_map_points, (*match)->score};
  }

  LikelihoodFieldMaker maker_;
  LikelihoodField grid_;
  std::optional<PrecomputationGrids> pyramid_;  // of the grid, once needed
  CorrelativeMatcher near_;
  BranchAndBoundMatcher far_;
};

}  // namespace wayfare::detail
