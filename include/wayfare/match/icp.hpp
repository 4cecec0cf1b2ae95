#pragma once

#include <wayfare/map/surface_map.hpp>
#include <wayfare/match/scan_matcher.hpp>

namespace wayfare {

struct IcpOptions {
  int max_iterations = 40;
  /// Iteration ends when a step is shorter than this, m and rad.
  double tolerance = 1e-4;
  /// Largest distance of a point from its nearest surface point, m; it shrinks to three times the
  /// median distance of the pairs.
  double max_correspondence_m = 1.0;
  /// Standard deviation of a point across its surface, m: the scale of the Cauchy kernel.
  double sigma_m = 0.03;
  /// Likelihood of a point without a pair, relative to one on a surface.
  double floor_probability = 0.01;
};

/// Point-to-line ICP (Chen and Medioni 1992; Censi 2008): minimises the distance of every point to
/// the line through its nearest surface point, until the pairs no longer change. `score` and
/// `mean_log_likelihood` are those of a likelihood field of `sigma_m` and `floor_probability`, from
/// the distances to the lines. Matches outside the window are rejected.
class IcpMatcher {
 public:
  using Map = SurfaceMap;

  explicit IcpMatcher(const IcpOptions& options = {}) : options_(options) {}

  [[nodiscard]] Result<std::optional<MatchResult>> match(const SurfaceMap& map,
                                                         const PointSet& points, const SE2d& prior,
                                                         const SearchWindow& window,
                                                         const MatchOptions& options = {}) const;

 private:
  IcpOptions options_;
};

static_assert(ScanMatcher<IcpMatcher>);

}  // namespace wayfare
