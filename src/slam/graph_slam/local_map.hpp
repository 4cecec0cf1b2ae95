#pragma once

#include <optional>
#include <span>

#include <Eigen/Core>

#include <wayfare/map/detail/precomputation_grids.hpp>
#include <wayfare/map/likelihood_field.hpp>
#include <wayfare/match/branch_and_bound.hpp>
#include <wayfare/match/correlative.hpp>
#include <wayfare/match/refine.hpp>

namespace wayfare {

/// Where points lie in a local map, and how sure that is.
struct Placement {
  SE2d T_map_points;
  double score = 0.0;  ///< agreement in [0, 1]; 0: no match
  /// Covariance of the translation in map axes, as a multiple of the variance in the best-known
  /// direction: near I in a room, long along a corridor.
  Eigen::Matrix2d spread = Eigen::Matrix2d::Identity();
};

/// A likelihood field of some scans, and the ways to place another scan in it. One a thread.
class LocalMap {
 public:
  /// False where the scans make no field (none, or spread beyond all measure): nothing matches
  /// then.
  bool render(std::span<const PlacedPoints> scans, double cell_m, double sigma_m);

  /// Exhaustive search of a small window, to a cell and a heading step.
  [[nodiscard]] Placement search(const PointSet& points, const SE2d& prior,
                                 const SearchWindow& window,
                                 const std::optional<Eigen::Matrix3d>& prior_information = {});

  /// The same for a large window by branch and bound; nothing scoring below `min_score` is found.
  /// The first call after `render` is the slower one: it prepares the map for those that follow.
  [[nodiscard]] Placement search_far(const PointSet& points, const SE2d& prior,
                                     const SearchWindow& window, double min_score);

  /// Between cells, from nearby; the spread is known only after this.
  [[nodiscard]] Placement refine(const PointSet& points, const SE2d& start) const;

 private:
  LikelihoodFieldMaker maker_;
  LikelihoodField grid_;
  std::optional<PrecomputationGrids> pyramid_;  // of the grid, once it was asked for
  CorrelativeMatcher near_;
  BranchAndBoundMatcher far_;
};

}  // namespace wayfare
