#pragma once

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>

#include <wayfare/core/angle.hpp>
#include <wayfare/sensors/wheels.hpp>

namespace wayfare {

/// The heading change between two times from a gyroscope's mean rates. Samples are in order of
/// time; the span must outlive this.
class GyroTurn {
 public:
  explicit GyroTurn(std::span<const GyroSample> samples) : samples_(samples) {}

  /// nullopt where there is a gap of half a second, or no sample up to `to`.
  [[nodiscard]] std::optional<Angle> between(LogTime from, LogTime to) const {
    constexpr double kSilence_s = 0.5;
    auto s = std::partition_point(samples_.begin(), samples_.end(),
                                  [&](const GyroSample& g) { return g.time <= from; });
    double turn = 0.0;
    LogTime at = from;
    for (; s != samples_.end() && at < to; ++s) {
      const LogTime end = std::min(s->time, to);
      if (!(to_seconds(s->time - at) < kSilence_s) || !std::isfinite(s->turn_rate_rad_s))
        return std::nullopt;
      turn += s->turn_rate_rad_s * to_seconds(end - at);
      at = end;
    }
    if (at < to) return std::nullopt;
    return Angle::radians(turn);
  }

 private:
  std::span<const GyroSample> samples_;
};

}  // namespace wayfare
