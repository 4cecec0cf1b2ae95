#pragma once

// Odometry and gyro between their samples.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <span>

#include <wayfare/core/angle.hpp>
#include <wayfare/core/detail/eigen_alignment.hpp>
#include <wayfare/core/se2.hpp>
#include <wayfare/sensors/measurements.hpp>
#include <wayfare/sensors/trajectory.hpp>

namespace wayfare {

/// Odometry at times between its samples: interpolated along the constant twist, constant before
/// the first and after the last sample. Samples are in order of time; their span must outlive this.
class OdometryTrack {
 public:
  /// A view of the samples.
  explicit OdometryTrack(std::span<const OdometrySample> samples) : samples_(samples) {}

  /// nullopt where there are no samples.
  [[nodiscard]] std::optional<Transform2<frame::Odom, frame::Base>> at(LogTime time) const {
    if (samples_.empty()) return std::nullopt;
    const auto after = std::partition_point(
        samples_.begin(), samples_.end(), [&](const OdometrySample& s) { return s.time <= time; });
    if (after == samples_.begin()) return samples_.front().T_odom_base;
    if (after == samples_.end()) return samples_.back().T_odom_base;
    const auto before = after - 1;
    const double u = to_seconds(time - before->time) / to_seconds(after->time - before->time);
    return Transform2<frame::Odom, frame::Base>(
        interpolate(before->T_odom_base.raw(), after->T_odom_base.raw(), u));
  }

 private:
  std::span<const OdometrySample> samples_;
};

/// The heading change between two times from a gyroscope's mean rates. Samples are in order of
/// time; the span must outlive this.
class GyroTurn {
 public:
  /// A view of the samples.
  explicit GyroTurn(std::span<const GyroSample> samples) : samples_(samples) {}

  /// nullopt where there is a gap of half a second, no sample up to `to`, or `to` before `from`.
  [[nodiscard]] std::optional<Angle> between(LogTime from, LogTime to) const {
    constexpr double kSilence_s = 0.5;
    if (to < from) return std::nullopt;
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
