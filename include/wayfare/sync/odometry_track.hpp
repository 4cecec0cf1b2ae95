#pragma once

#include <algorithm>
#include <cstddef>
#include <optional>
#include <span>

#include <wayfare/core/se2.hpp>
#include <wayfare/sensors/trajectory.hpp>

namespace wayfare {

/// Odometry at times between its samples: interpolated along the constant twist, constant before
/// the first and after the last sample. Samples are in order of time; their span must outlive this.
class OdometryTrack {
 public:
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

}  // namespace wayfare
