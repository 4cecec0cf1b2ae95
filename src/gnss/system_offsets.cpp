#include <wayfare/gnss/single_point.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include <wayfare/gnss/ephemerides.hpp>

namespace wayfare {
void SystemOffsets::learn(const SinglePoint& point) {
  const double gps = point.clock_bias_m[0];
  if (!point.consistent || point.degrees_of_freedom < 2 || !std::isfinite(gps)) return;
  for (std::size_t s = 1; s < tracks_.size(); ++s) {
    if (!std::isfinite(point.clock_bias_m[s])) continue;
    Track& track = tracks_[s];
    const double offset = point.clock_bias_m[s] - gps;
    const double gain = 1.0 / std::min(++track.count, 200);
    if (track.count == 1) track.mean_m = offset;
    const double limit = track.count <= 10 ? 1e9 : 5.0 * std::max(track.spread_m, 0.1);
    const double off = std::clamp(offset - track.mean_m, -limit, limit);
    track.mean_m += gain * off;
    track.spread_m += gain * (std::abs(off) - track.spread_m);
  }
}

std::optional<ClockOffset> SystemOffsets::of(GnssSystem system) const {
  const Track& track = tracks_[index_of(system)];
  if (system == GnssSystem::gps) return ClockOffset{0.0, 0.0};
  if (track.count < 10) return std::nullopt;
  // Errors of successive epochs are correlated: half of one epoch's deviation.
  return ClockOffset{track.mean_m, std::max(0.5 * track.spread_m, 0.3)};
}

std::array<std::optional<ClockOffset>, kGnssSystems> SystemOffsets::all() const {
  std::array<std::optional<ClockOffset>, kGnssSystems> result;
  for (const GnssSystem system : kAllGnssSystems) result[index_of(system)] = of(system);
  return result;
}

RangeEpoch on_one_clock(const RangeEpoch& epoch, const SystemOffsets& offsets) {
  RangeEpoch result = epoch;
  for (CorrectedRange& r : result.satellites) {
    const std::optional<ClockOffset> offset = offsets.of(r.satellite.system);
    r.range_m -= offset ? offset->offset_m : std::numeric_limits<double>::quiet_NaN();
    if (offset) r.range_sigma_m = std::hypot(r.range_sigma_m, offset->sigma_m);
  }
  return result;
}

GnssFix to_fix(const SinglePoint& point) {
  GnssFix fix{point.instant, point.position, point.position_covariance_ned_m2,
              point.velocity_ned_mps};
  if (point.velocity_ned_mps) fix.velocity_covariance_ned = point.velocity_covariance_ned;
  return fix;
}

}  // namespace wayfare
