#pragma once

#include <cmath>

#include <wayfare/core/geodesy.hpp>
#include <wayfare/core/time.hpp>
#include <wayfare/sensors/measurements.hpp>

namespace wayfare::nav {

/// Near the ground, and not where north and east are undefined.
[[nodiscard]] inline bool is_on_earth(const Geodetic& p) {
  return std::abs(p.latitude.degrees()) < 89.99 && std::abs(p.longitude.degrees()) <= 360.0 &&
         p.height_m > -1e5 && p.height_m < 1e7;
}

[[nodiscard]] inline ImuSample interpolate(const ImuSample& a, const ImuSample& b, LogTime at) {
  const double k = to_seconds(at - a.time) / to_seconds(b.time - a.time);
  return {at, (1.0 - k) * a.angular_rate_radps + k * b.angular_rate_radps,
          (1.0 - k) * a.specific_force_mps2 + k * b.specific_force_mps2};
}

}  // namespace wayfare::nav
