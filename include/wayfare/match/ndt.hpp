#pragma once

#include <wayfare/map/ndt_map.hpp>
#include <wayfare/match/scan_matcher.hpp>

namespace wayfare {

struct NdtOptions {
  /// On each level.
  int max_iterations = 20;
  /// A step shorter than this ends a level's climb, m and rad.
  double tolerance = 1e-4;
  /// Likelihood of a point where there is no distribution, beside one at a mean.
  double floor_probability = 0.01;
};

/// Climbs the normal distributions transform (Biber and Straßer 2003), coarse level to fine: most
/// Σ exp(−½ (p − µ)ᵀ Σ⁻¹ (p − µ)), the mean of four tilings, by damped Gauss-Newton steps whose
/// weights are the exponentials. On the finest level: `score` is that mean for the best of the
/// four, `mean_log_likelihood` its logarithm's mean, not below the floor's. The window bounds how
/// far from the prior a match is believed.
class NdtMatcher {
 public:
  using Map = NdtMap;

  explicit NdtMatcher(const NdtOptions& options = {}) : options_(options) {}

  [[nodiscard]] Result<std::optional<MatchResult>> match(const NdtMap& map, const PointSet& points,
                                                         const SE2d& prior,
                                                         const SearchWindow& window,
                                                         const MatchOptions& options = {}) const;

 private:
  NdtOptions options_;
};

static_assert(ScanMatcher<NdtMatcher>);

}  // namespace wayfare
