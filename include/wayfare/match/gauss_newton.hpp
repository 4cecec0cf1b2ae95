#pragma once

#include <optional>

#include <wayfare/map/probability_grid.hpp>
#include <wayfare/match/scan_matcher.hpp>

namespace wayfare {

/// How the probability between cell centres is had from those about it.
enum class Interpolation {
  bilinear,  ///< of 2×2 cells: quick, with kinks where cells meet (Kohlbrecher et al. 2011)
  bicubic,   ///< of 4×4 cells, Catmull and Rom: smooth, so that the climb ends at its summit
};

struct GaussNewtonOptions {
  Interpolation interpolation = Interpolation::bilinear;
  /// On each table; one that finds nothing better ends sooner.
  int max_iterations = 10;
  /// The coarsest table is climbed from the prior turned by multiples of this too, as far as the
  /// window reaches, and the best end goes on; zero: from the prior alone.
  Angle start_step{};
  /// A step shorter than this ends a table's climb, m and rad.
  double tolerance = 1e-4;
  /// Standard deviation of 1 − p at a point's true place. Larger: the prior counts for more.
  double residual_sigma = 0.4;
  /// Of a point across the wall it was matched with, m: what the covariance is made of, with the
  /// scan's own normals. (σ²H⁻¹ of the table's gradients is as sure along a bare corridor as across
  /// it.)
  double point_sigma_m = 0.05;
};

/// Climbs from the prior to the least Σ (1 − p(S(ξ)))² by damped Gauss-Newton steps, coarse table
/// to fine (Kohlbrecher et al. 2011, (7)-(13), with the sum over the points in (12) and (13)): a
/// small window's match in microseconds, but only downhill from the prior. With bicubic
/// interpolation and `prior_information` it is the least-squares matcher of Hess et al. 2016, (1).
/// The window bounds how far from the prior a match is believed. On the finest table, with r = 1 −
/// p: `score` is 1 − √(Σr²/N), `mean_log_likelihood` −Σr²/2Nσ².
class GaussNewtonMatcher {
 public:
  using Map = ProbabilityPyramid;

  explicit GaussNewtonMatcher(const GaussNewtonOptions& options = {}) : options_(options) {}

  [[nodiscard]] Result<std::optional<MatchResult>> match(const ProbabilityPyramid& map,
                                                         const PointSet& points, const SE2d& prior,
                                                         const SearchWindow& window,
                                                         const MatchOptions& options = {}) const;

 private:
  GaussNewtonOptions options_;
};

static_assert(ScanMatcher<GaussNewtonMatcher>);

}  // namespace wayfare
