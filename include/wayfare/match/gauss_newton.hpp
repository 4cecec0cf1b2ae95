#pragma once

// Scan matching by Gauss-Newton: refinement between cells, and on grids of several resolutions.

#include <optional>

#include <Eigen/Core>

#include <wayfare/core/result.hpp>
#include <wayfare/core/se2.hpp>
#include <wayfare/map/likelihood_field.hpp>
#include <wayfare/map/probability_grid.hpp>
#include <wayfare/match/scan_matcher.hpp>
#include <wayfare/sensors/point_set.hpp>

namespace wayfare {

/// ln p, bilinear between cell centres, and its gradient per metre. The floor outside the map.
struct FieldSample {
  double log_likelihood;     ///< nats
  Eigen::Vector2d gradient;  ///< nats per metre, map axes
};
/// The sample of the field at a point of the map, m.
[[nodiscard]] FieldSample interpolate(const LikelihoodField& grid, const Eigen::Vector2d& p_map);

/// A Gaussian prior of refine(), as MatchOptions has it for a search.
struct RefinePrior {
  SE2d pose;                        ///< mean
  Eigen::Matrix3d information;      ///< of the offset from it, in its own axes
  double independent_points = 0.0;  ///< to which Σ ln p is scaled; 0: all points are independent
};

/// When refine() stops, and its prior.
struct RefineOptions {
  int max_iterations = 10;  ///< steps computed, refused ones too
  /// Iteration ends when a step is shorter than this, m and rad.
  double tolerance = 1e-4;
  /// Largest distance of the refined pose from its start, m.
  double max_shift_m = 0.2;
  /// With it, the maximum is that of the scaled Σ ln p plus the prior's log density.
  std::optional<RefinePrior> prior{};
};

/// A refined pose and its figures.
struct RefineResult {
  SE2d T_map_points;                 ///< maximum of Σ ln p near the start
  double mean_log_likelihood = 0.0;  ///< of the interpolated field
  double score = 0.0;                ///< as MatchResult::score
  /// JᵀJ at the solution, in the pose's own axes: the inverse of the covariance if the points are
  /// independent; singular along unconstrained directions.
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  int iterations = 0;  ///< steps computed, refused ones too
};

/// Refines a matched pose to the maximum of Σ ln p between cells: damped Gauss-Newton on the
/// residuals √(−2 ln p), which for a likelihood field are distances in σ (compare the
/// scan-to-map step of Kohlbrecher et al. 2011). Never worse than its start. The figures are those
/// of the points alone, with a prior too. The kinks of the bilinear field slow the convergence: in
/// a room the default ten iterations end about 5 mm from the maximum (up to 15 mm, 7e-4 nats per
/// point below it), 200 within 1 mm in three cases of four.
[[nodiscard]] Result<RefineResult> refine(const LikelihoodField& grid, const PointSet& points,
                                          const SE2d& start, const RefineOptions& options = {});

/// Interpolation of the probability between cell centres.
enum class Interpolation {
  bilinear,  ///< of 2×2 cells: fast, with kinks at cell borders (Kohlbrecher et al. 2011)
  bicubic,   ///< of 4×4 cells, Catmull-Rom: smooth, so that the iteration converges
};

/// Interpolation, starts and weights of a GaussNewtonMatcher.
struct GaussNewtonOptions {
  Interpolation interpolation = Interpolation::bilinear;  ///< of the tables
  /// On each table.
  int max_iterations = 10;
  /// Multi-start on the coarsest table, from the prior rotated by multiples of this within the
  /// window; the best result is used. Zero: from the prior only.
  Angle start_step{};
  /// Iteration on a table ends when a step is shorter than this, m and rad.
  double tolerance = 1e-4;
  /// Standard deviation of 1 − p at a point's true position. Larger: more weight of the prior.
  double residual_sigma = 0.4;
  /// Standard deviation of a point across its wall, m: gives the covariance with the scan's
  /// normals. (σ²H⁻¹ of the table's gradients is as small along a bare corridor as across it.)
  double point_sigma_m = 0.05;
};

/// Minimises Σ (1 − p(S(ξ)))² from the prior by damped Gauss-Newton steps, coarse table to fine
/// (Kohlbrecher et al. 2011, (7)-(13), with the sum over the points in (12) and (13)): takes
/// microseconds, but finds only the local minimum. With bicubic interpolation and
/// `prior_information` it is the least-squares matcher of Hess et al. 2016, (1). Matches outside
/// the window are rejected. On the finest table, with r = 1 − p: `score` is 1 − √(Σr²/N),
/// `mean_log_likelihood` −Σr²/2Nσ².
class GaussNewtonMatcher {
 public:
  using Map = ProbabilityPyramid;  ///< tables of the same area, coarse to fine
  static constexpr std::string_view kName = "Gauss-Newton";  ///< in tables of results

  /// Keeps the options.
  explicit GaussNewtonMatcher(const GaussNewtonOptions& options = {}) : options_(options) {}

  /// The local minimum from the prior. Errors: those of ScanMatcher.
  [[nodiscard]] Result<std::optional<MatchResult>> match(const ProbabilityPyramid& map,
                                                         const PointSet& points, const SE2d& prior,
                                                         const SearchWindow& window,
                                                         const MatchOptions& options = {}) const;

 private:
  GaussNewtonOptions options_;
};

static_assert(ScanMatcher<GaussNewtonMatcher>);

}  // namespace wayfare
