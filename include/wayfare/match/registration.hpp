#pragma once

// Registration of points without a grid: point-to-line ICP and NDT.

#include <optional>
#include <span>
#include <string_view>

#include <wayfare/map/ndt_map.hpp>
#include <wayfare/map/surface_map.hpp>
#include <wayfare/match/scan_matcher.hpp>

namespace wayfare {

/// Convergence, pairs and kernel of an IcpMatcher.
struct IcpOptions {
  int max_iterations = 40;  ///< each with new pairs
  /// Iteration ends when a step is shorter than this, m and rad.
  double tolerance = 1e-4;
  /// Largest distance of a point from its nearest surface point, m; it shrinks to three times the
  /// median distance of the pairs.
  double max_correspondence_m = 1.0;
  /// Standard deviation of a point across its surface, m: the scale of the Cauchy kernel.
  double sigma_m = 0.03;
  /// Likelihood of a point without a pair, relative to one on a surface.
  double floor_probability = 0.01;
  SurfaceMapOptions map{};  ///< of `make_map`
};

/// Point-to-line ICP (Chen and Medioni 1992; Censi 2008): minimises the distance of every point to
/// the line through its nearest surface point, until the pairs no longer change. `score` and
/// `mean_log_likelihood` are those of a likelihood field of `sigma_m` and `floor_probability`, from
/// the distances to the lines. Matches outside the window are rejected.
class IcpMatcher {
 public:
  using Map = SurfaceMap;                           ///< surface points with normals
  static constexpr std::string_view kName = "ICP";  ///< in tables of results

  /// Keeps the options.
  explicit IcpMatcher(const IcpOptions& options = {}) : options_(options) {}

  /// Surface points of the scans. Errors: those of SurfaceMap::make.
  [[nodiscard]] Result<SurfaceMap> make_map(std::span<const PlacedPoints> scans) const {
    return SurfaceMap::make(scans, options_.map);
  }

  /// The local minimum from the prior. Errors: those of ScanMatcher.
  [[nodiscard]] Result<std::optional<MatchResult>> match(const SurfaceMap& map,
                                                         const PointSet& points, const SE2d& prior,
                                                         const SearchWindow& window,
                                                         const MatchOptions& options = {}) const;

 private:
  IcpOptions options_;
};

static_assert(MappingMatcher<IcpMatcher>);

/// Convergence and floor of an NdtMatcher.
struct NdtOptions {
  /// On each level.
  int max_iterations = 20;
  /// Iteration on a level ends when a step is shorter than this, m and rad.
  double tolerance = 1e-4;
  /// Likelihood of a point without a distribution, relative to one at a mean.
  double floor_probability = 0.01;
  NdtMapOptions map{};  ///< of `make_map`
};

/// Matching with the normal distributions transform (Biber and Straßer 2003), coarse level to fine:
/// maximises Σ exp(−½ (p − µ)ᵀ Σ⁻¹ (p − µ)), the mean of four tilings, by damped Gauss-Newton steps
/// weighted by the exponentials. On the finest level, with the best of the four tilings: `score` is
/// the mean of the exponentials, `mean_log_likelihood` that of their logarithms, bounded by the
/// floor. Matches outside the window are rejected.
class NdtMatcher {
 public:
  using Map = NdtMap;                               ///< distributions on squares, coarse to fine
  static constexpr std::string_view kName = "NDT";  ///< in tables of results

  /// Keeps the options.
  explicit NdtMatcher(const NdtOptions& options = {}) : options_(options) {}

  /// Distributions of the scans' points. Errors: those of NdtMap::make.
  [[nodiscard]] Result<NdtMap> make_map(std::span<const PlacedPoints> scans) const {
    return NdtMap::make(scans, options_.map);
  }

  /// The local maximum from the prior. Errors: those of ScanMatcher.
  [[nodiscard]] Result<std::optional<MatchResult>> match(const NdtMap& map, const PointSet& points,
                                                         const SE2d& prior,
                                                         const SearchWindow& window,
                                                         const MatchOptions& options = {}) const;

 private:
  NdtOptions options_;
};

static_assert(MappingMatcher<NdtMatcher>);

}  // namespace wayfare
