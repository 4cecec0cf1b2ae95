#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <optional>

#include <wayfare/core/time.hpp>
#include <wayfare/slam/detail/pose_measures.hpp>
#include <wayfare/slam/monte_carlo.hpp>

namespace wayfare::detail {

/// Recent scans of one sensor and their agreement with the map.
template <class Pose>
struct SensorHistory {
  Pose since_weighed = Pose::identity();  // motion since the last scan that was weighed
  std::optional<LogTime> weighed_at = {};
  double recent = 0.0, last = 0.0;  // recent agreement, and that of the last scan
  double usual = 0.0;               // while converged, and since a search that found nothing better
  double best = 0.0;  // while converged: reveals a pose that fits no better than others

  /// After a change of pose. The usual agreement on this map is kept, to detect a wrong pose.
  void reset_recent() { recent = last = 0.0; }
  void remember(double agreement, bool converged, double search_ratio) {
    constexpr double kFast = 0.3, kSlow = 0.02;
    last = agreement;
    recent += (recent == 0.0 ? 1.0 : kFast) * (agreement - recent);
    if (!converged) return;
    // Slower still at a poor fit, or the usual agreement would follow a kidnapped robot.
    const auto follow = [&](double& value) {
      const double rate = recent < search_ratio * value ? 0.1 * kSlow : kSlow;
      value += (value == 0.0 ? 1.0 : rate) * (agreement - value);
    };
    follow(usual);
    follow(best);
  }

  [[nodiscard]] bool is_due(LogTime time, const MonteCarloOptions& options) const {
    return !weighed_at || since_weighed.translation().norm() >= options.update_travel_m ||
           turn_of(since_weighed) >= options.update_turn.radians() ||
           to_seconds(time - *weighed_at) >= options.update_time_s;
  }
  [[nodiscard]] bool fits_worse_than(double agreement) const {
    return recent > 0.0 && recent < agreement;
  }
};

/// A second set of particles, drawn globally when the first is unreliable, and its odds.
template <class Filter, std::size_t Sensors>
struct RelocalisationHypothesis {
  Filter filter;
  double log_odds;            // that it is right rather than the first
  bool for_poor_fit = false;  // started because of a poor fit, not for confirmation
  std::array<int, Sensors> scans{};

  /// The largest of the counts: a second sensor must not shorten the path allowed to a hypothesis.
  [[nodiscard]] int age() const { return *std::max_element(scans.begin(), scans.end()); }
};

}  // namespace wayfare::detail
