#pragma once

#include <algorithm>
#include <optional>
#include <span>

#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>

#include <wayfare/map/detail/precomputation_grids.hpp>
#include <wayfare/map/likelihood_field.hpp>
#include <wayfare/match/correlative.hpp>
#include <wayfare/match/gauss_newton.hpp>
#include <wayfare/slam/detail/motion.hpp>

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
    // Errors of a scan's points are correlated, and in a corridor those beyond the mapped area bias
    // the pose.
    options.independent_points = 8.0;
    return placement(near_.match(grid_, points, prior, window, options), prior);
  }

  /// The same for a large window by branch and bound, for scores of at least `min_score`. The first
  /// call after `render` is slower: it computes the precomputation grids.
  [[nodiscard]] Placement search_far(const PointSet& points, const SE2d& prior,
                                     const SearchWindow& window, double min_score) {
    MatchOptions options;
    options.min_score = min_score;
    if (!pyramid_) pyramid_.emplace(grid_);
    return placement(far_.match(*pyramid_, points, prior, window, options), prior);
  }

  /// Refinement between cells; only this estimates the spread.
  [[nodiscard]] Placement refine(const PointSet& points, const SE2d& start) const {
    const auto fine = wayfare::refine(grid_, points, start);
    if (!fine) return {start};
    // The information is in the pose's own axes, the spread in the map's.
    const Eigen::Matrix2d r = fine->T_map_points.rotation().matrix();
    return {fine->T_map_points, fine->score, r * spread_of(fine->information) * r.transpose()};
  }

 private:
  /// The match, if any; else the prior with a score of 0.
  static Placement placement(const Result<std::optional<MatchResult>>& match, const SE2d& prior) {
    if (!match || !*match) return {prior};
    return {(*match)->T_map_points, (*match)->score};
  }

  /// The translation block of information⁻¹, scaled to 1 in its best-known direction.
  static Eigen::Matrix2d spread_of(const Eigen::Matrix3d& information) {
    constexpr double kTiny = 1e-9;
    const double scale = information.topLeftCorner<2, 2>().trace();
    const Eigen::Matrix3d regular =
        information + kTiny * std::max(scale, 1.0) * Eigen::Matrix3d::Identity();
    const Eigen::Matrix2d covariance = regular.inverse().topLeftCorner<2, 2>();
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> eigen(covariance, Eigen::EigenvaluesOnly);
    return covariance / std::max(eigen.eigenvalues()[0], 1e-300);
  }

  LikelihoodFieldMaker maker_;
  LikelihoodField grid_;
  std::optional<PrecomputationGrids> pyramid_;  // of the grid, once needed
  CorrelativeMatcher near_;
  BranchAndBoundMatcher far_;
};

/// Ambiguity of a match along each axis of its spread. σ grows with the cube of the spread, from
/// nothing in a room (1-3) to decimetres in a corridor without doors (7-13), where the few
/// gradients along the walls come from cells and noise.
struct Ambiguity {
  explicit Ambiguity(const Placement& match) {
    constexpr double kSigmaPerCubedSpread_m = 0.0004;
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> eigen(match.spread);
    directions = eigen.eigenvectors();
    variance = (kSigmaPerCubedSpread_m * eigen.eigenvalues().array().cube()).square();
  }

  Eigen::Matrix2d directions;  ///< columns, map axes
  Eigen::Vector2d variance;    ///< m²
};

/// The match shifted to the motion model's prediction along directions that the scene does not
/// constrain: x = x_match + Σ_match (Σ_match + Σ_motion)⁻¹ (x_motion − x_match).
[[nodiscard]] inline SE2d settle(const Placement& match, const SE2d& predicted,
                                 const Motion& motion) {
  const Ambiguity open(match);
  const double motion_variance = motion.sigma[0] * motion.sigma[0];
  const Eigen::Vector2d gain =
      open.variance.cwiseQuotient(open.variance + Eigen::Vector2d::Constant(motion_variance));
  const Eigen::Vector2d gap = predicted.translation() - match.T_map_points.translation();
  const Eigen::Vector2d shift =
      open.directions * gain.asDiagonal() * open.directions.transpose() * gap;
  return SE2d(Eigen::Vector2d(match.T_map_points.translation() + shift),
              match.T_map_points.rotation());
}

/// Ω of an edge whose match has `sigma_m` and `sigma_rad`, lower along directions that the scene
/// does not constrain; `rotation` leads from the edge's axes to the map's.
[[nodiscard]] inline Eigen::Matrix3d match_information(const Placement& match, const SO2d& rotation,
                                                       double sigma_m, double sigma_rad) {
  const Ambiguity open(match);
  const Eigen::Vector2d variance = open.variance + Eigen::Vector2d::Constant(sigma_m * sigma_m);
  const Eigen::Matrix2d axes = rotation.matrix().transpose() * open.directions;
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  information.topLeftCorner<2, 2>() =
      axes * variance.cwiseInverse().asDiagonal() * axes.transpose();
  information(2, 2) = 1.0 / (sigma_rad * sigma_rad);
  return information;
}

}  // namespace wayfare
