#pragma once

// How much of a heading that a map tells is news to the filter that helped to make the map.

#include <cmath>
#include <optional>

#include <wayfare/core/angle.hpp>
#include <wayfare/core/time.hpp>

namespace wayfare {

struct MapHeadingParameters {
  double spacing_s = 1.0;             ///< from one heading that is told to the next
  Angle sigma = Angle::degrees(0.5);  ///< of the map's own heading, beside the match's
  double correlation_s = 5.0;         ///< how long an error of the map's heading lasts
  double largest_share = 0.8;         ///< of the prior in a match, above which it tells nothing
};

/// A matched heading is no independent measurement: its prior came from the same gyro, and scans
/// matched to one map share the map's error. So what the prior brought is not counted again, and of
/// errors that last an independent one's equivalent is told.
class MapHeading {
 public:
  explicit MapHeading(const MapHeadingParameters& p = {}) : p_(p) {}

  /// The variance to tell a match's heading with, rad²; none where it is not to be told. `match`:
  /// its variance by the scan alone, `prior`: that of the expected heading, rad².
  [[nodiscard]] std::optional<double> tell(LogTime time, double match, double prior) {
    if (!(match > 0.0) || !(prior > 0.0) || !std::isfinite(match + prior)) return std::nullopt;
    const double dt = last_ ? to_seconds(time - *last_) : p_.correlation_s;
    if (last_ && dt >= 0.0 && dt < p_.spacing_s) return std::nullopt;
    // The matched heading is (1 − s)·scan + s·prior: an innovation of it is 1 − s of the scan's.
    const double share = match / (match + prior);
    if (share > p_.largest_share) return std::nullopt;
    last_ = time;
    const double sigma = p_.sigma.radians();
    // A Gauss-Markov error sampled every dt has the mean of a white one (1 + ρ)/(1 − ρ) as large.
    const double rho = std::exp(-std::abs(dt) / p_.correlation_s);
    return (match + sigma * sigma * (1.0 + rho) / (1.0 - rho)) / ((1.0 - share) * (1.0 - share));
  }

 private:
  MapHeadingParameters p_;
  std::optional<LogTime> last_;
};

}  // namespace wayfare
