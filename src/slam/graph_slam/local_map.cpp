#include "slam/graph_slam/local_map.hpp"

#include <algorithm>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>

namespace wayfare {
namespace {

/// Likelihood of an outlier relative to a fit. A point counts as one from 1.8 σ, so that moved or
/// previously occluded objects do not attract it.
constexpr double kOutlierProbability = 0.2;
/// Errors of a scan's points are correlated, and in a corridor those beyond the mapped area bias
/// the pose: effective number of independent points against the prior.
constexpr double kIndependentPoints = 8.0;

/// The translation block of information⁻¹, scaled to 1 in its best-known direction.
Eigen::Matrix2d spread_of(const Eigen::Matrix3d& information) {
  constexpr double kTiny = 1e-9;
  const double scale = information.topLeftCorner<2, 2>().trace();
  const Eigen::Matrix3d regular =
      information + kTiny * std::max(scale, 1.0) * Eigen::Matrix3d::Identity();
  const Eigen::Matrix2d covariance = regular.inverse().topLeftCorner<2, 2>();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> eigen(covariance, Eigen::EigenvaluesOnly);
  return covariance / std::max(eigen.eigenvalues()[0], 1e-300);
}

/// The match, if any; else the prior with a score of 0.
Placement placement(const Result<std::optional<MatchResult>>& match, const SE2d& prior) {
  if (!match || !*match) return {prior};
  return {(*match)->T_map_points, (*match)->score};
}

}  // namespace

bool LocalMap::render(std::span<const PlacedPoints> scans, double cell_m, double sigma_m) {
  const LikelihoodFieldOptions options{cell_m, sigma_m, kOutlierProbability};
  pyramid_.reset();
  return maker_.make(scans, options, grid_).has_value();
}

Placement LocalMap::search(const PointSet& points, const SE2d& prior, const SearchWindow& window,
                           const std::optional<Eigen::Matrix3d>& prior_information) {
  MatchOptions options;
  options.prior_information = prior_information;
  options.independent_points = kIndependentPoints;
  return placement(near_.match(grid_, points, prior, window, options), prior);
}

Placement LocalMap::search_far(const PointSet& points, const SE2d& prior,
                               const SearchWindow& window, double min_score) {
  MatchOptions options;
  options.min_score = min_score;
  if (!pyramid_) pyramid_.emplace(grid_);
  return placement(far_.match(*pyramid_, points, prior, window, options), prior);
}

Placement LocalMap::refine(const PointSet& points, const SE2d& start) const {
  const auto fine = wayfare::refine(grid_, points, start);
  if (!fine) return {start};
  // The information is in the pose's own axes, the spread in the map's.
  const Eigen::Matrix2d r = fine->T_map_points.rotation().matrix();
  return {fine->T_map_points, fine->score, r * spread_of(fine->information) * r.transpose()};
}

}  // namespace wayfare
