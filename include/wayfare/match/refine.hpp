#pragma once

#include <Eigen/Core>

#include <wayfare/core/result.hpp>
#include <wayfare/core/se2.hpp>
#include <wayfare/map/likelihood_field.hpp>
#include <wayfare/sensors/point_set.hpp>

namespace wayfare {

/// ln p, bilinear between cell centres, and its gradient per metre. The floor outside the map.
struct FieldSample {
  double log_likelihood;
  Eigen::Vector2d gradient;
};
[[nodiscard]] FieldSample interpolate(const LikelihoodField& grid, const Eigen::Vector2d& p_map);

struct RefineOptions {
  int max_iterations = 10;
  /// Iteration ends when a step is shorter than this, m and rad.
  double tolerance = 1e-4;
  /// Largest distance of the refined pose from its start, m.
  double max_shift_m = 0.2;
};

struct RefineResult {
  SE2d T_map_points;
  double mean_log_likelihood = 0.0;  ///< of the interpolated field
  double score = 0.0;                ///< as MatchResult::score
  /// JᵀJ at the solution, in the pose's own axes: the inverse of the covariance if the points are
  /// independent; singular along unconstrained directions.
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  int iterations = 0;
  bool moved = false;  ///< false: nothing better than the start was found
};

/// Refines a matched pose to the maximum of Σ ln p between cells: damped Gauss-Newton on the
/// residuals √(−2 ln p), which for a likelihood field are distances in σ (compare the
/// scan-to-map step of Kohlbrecher et al. 2011). Never worse than its start. The kinks of the
/// bilinear field slow the convergence: in a room the default ten iterations end about 5 mm from
/// the maximum (up to 15 mm, 7e-4 nats per point below it), 200 within 1 mm in three cases of four.
[[nodiscard]] Result<RefineResult> refine(const LikelihoodField& grid, const PointSet& points,
                                          const SE2d& start, const RefineOptions& options = {});

}  // namespace wayfare
