#pragma once

#include <wayfare/map/surface_map.hpp>
#include <wayfare/match/scan_matcher.hpp>

namespace wayfare {

struct IcpOptions {
  int max_iterations = 40;
  /// A step shorter than this ends it, m and rad.
  double tolerance = 1e-4;
  /// Points farther than this from every surface are matched with none, m; the reach shrinks to
  /// three times what is usual among those matched.
  double reach_m = 1.0;
  /// Standard deviation of a point across its surface, m: beyond it a pair's pull fades (Cauchy).
  double sigma_m = 0.03;
  /// Likelihood of a point matched with nothing, beside one in its surface.
  double floor_probability = 0.01;
};

/// Iterative closest points to lines (Chen and Medioni 1992; Censi 2008): every point is drawn to
/// the line through its nearest surface point, until the pairs stay. `score` and
/// `mean_log_likelihood` are those of a likelihood field of `sigma_m` and `floor_probability`, from
/// the distances to the lines. The window bounds how far from the prior a match is believed.
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
