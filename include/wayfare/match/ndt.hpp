#pragma once

#include <wayfare/map/ndt_map.hpp>
#include <wayfare/match/scan_matcher.hpp>

namespace wayfare {

struct NdtOptions {
  /// On each level.
  int max_iterations = 20;
  /// Iteration on a level ends when a step is shorter than this, m and rad.
  double tolerance = 1e-4;
  /// Likelihood of a point without a distribution, relative to one at a mean.
  double floor_probability = 0.01;
};

/// Matching with the normal distributions transform (Biber and Straßer 2003), coarse level to fine:
/// maximises Σ exp(−½ (p − µ)ᵀ Σ⁻¹ (p − µ)), the mean of four tilings, by damped Gauss-Newton steps
/// weighted by the exponentials. On the finest level, with the best of the four tilings: `score` is
/// the mean of the exponentials, `mean_log_likelihood` that of their logarithms, bounded by the
/// floor. Matches outside the window are rejected.
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
