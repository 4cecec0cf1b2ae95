#pragma once

#include <optional>
#include <span>

#include <Eigen/Core>

#include <wayfare/map/detail/precomputation_grids.hpp>
#include <wayfare/map/likelihood_field.hpp>
#include <wayfare/match/correlative.hpp>
#include <wayfare/match/gauss_newton.hpp>

namespace wayfare {

/// Pose of points in a local map, with its uncertainty.
struct Placement {
  SE2d T_map_points;
  double score = 0.0;  ///< agreement in [0, 1]; 0: no match
  /// Covariance of the translation in map axes, as a multiple of the variance in the best-known
  /// direction: near I in a room, long along a corridor.
  Eigen::Matrix2d spread = Eigen::Matrix2d::Identity();
};

/// A likelihood field of some scans, with matchers for another scan. One per thread.
class LocalMap {
 public:
  /// False if the scans make no field (none, or extending too far): nothing matches then.
  bool render(std::span<const PlacedPoints> scans, double cell_m, double sigma_m);

  /// Exhaustive search of a small window, to one cell and one heading step.
  [[nodiscard]] Placement search(const PointSet& points, const SE2d& prior,
                                 const SearchWindow& window,
                                 const std::optional<Eigen::Matrix3d>& prior_information = {});

  /// The same for a large window by branch and bound, for scores of at least `min_score`. The first
  /// call after `render` is slower: it computes the precomputation grids.
  [[nodiscard]] Placement search_far(const PointSet& points, const SE2d& prior,
                                     const SearchWindow& window, double min_score);

  /// Refinement between cells; only this estimates the spread.
  [[nodiscard]] Placement refine(const PointSet& points, const SE2d& start) const;

 private:
  LikelihoodFieldMaker maker_;
  LikelihoodField grid_;
  std::optional<PrecomputationGrids> pyramid_;  // of the grid, once needed
  CorrelativeMatcher near_;
  BranchAndBoundMatcher far_;
};

}  // namespace wayfare
