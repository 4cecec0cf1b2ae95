#pragma once

// Variance of a map-matched heading for the filter that provided its prior.

#include <cmath>
#include <optional>

#include <wayfare/core/angle.hpp>
#include <wayfare/core/time.hpp>

namespace wayfare {

struct MapHeadingParameters {
  double spacing_s = 1.0;             ///< between headings used
  Angle sigma = Angle::degrees(0.5);  ///< of the map's heading, in addition to the match's
  double correlation_s = 5.0;         ///< of the map's heading error
  double largest_share = 0.8;         ///< of the prior in a match; above it the match is not used
};

/// A matched heading is not independent: its prior comes from the same gyro, and scans matched to
/// one map share its error. The returned variance removes the prior's share and replaces the
/// correlated error by an equivalent independent one.
class MapHeading {
 public:
  explicit MapHeading(const MapHeadingParameters& p = {}) : p_(p) {}

  /// Variance to use for a matched heading, rad²; none if it must not be used. `match`: its
  /// variance from the scan alone, `prior`: that of the predicted heading, rad².
  [[nodiscard]] std::optional<double> independent_variance(LogTime time, double match,
                                                           double prior) {
    if (!(match > 0.0) || !(prior > 0.0) || !std::isfinite(match + prior)) return std::nullopt;
    const double dt = last_ ? to_seconds(time - *last_) : p_.correlation_s;
    if (last_ && dt >= 0.0 && dt < p_.spacing_s) return std::nullopt;
    // The matched heading is (1 − s)·scan + s·prior: its innovation is 1 − s times the scan's.
    const double share = match / (match + prior);
    if (share > p_.largest_share) return std::nullopt;
    last_ = time;
    const double sigma = p_.sigma.radians();
    // The mean of a Gauss-Markov error sampled every dt has (1 + ρ)/(1 − ρ) times the variance of
    // that of a white one.
    const double rho = std::exp(-std::abs(dt) / p_.correlation_s);
    return (match + sigma * sigma * (1.0 + rho) / (1.0 - rho)) / ((1.0 - share) * (1.0 - share));
  }

 private:
  MapHeadingParameters p_;
  std::optional<LogTime> last_;
};

}  // namespace wayfare
