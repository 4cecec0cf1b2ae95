#pragma once

#include <algorithm>
#include <cmath>

#include <Eigen/Core>

#include <wayfare/core/gaussian.hpp>
#include <wayfare/nav/gnss_ins.hpp>

#include "nav/gnss_ins/on_earth.hpp"
#include "nav/gnss_ins/receiver_clocks.hpp"

namespace wayfare::nav {

/// Whether a measurement is finite and within the range of any sensor of its kind.
[[nodiscard]] inline bool plausible(const ImuSample& s) {
  return s.angular_rate_radps.allFinite() && s.specific_force_mps2.allFinite() &&
         s.angular_rate_radps.cwiseAbs().maxCoeff() < 200.0 &&
         s.specific_force_mps2.cwiseAbs().maxCoeff() < 5000.0;
}

/// Slower than 100 km/s.
[[nodiscard]] inline bool plausible_velocity(const Eigen::Vector3d& mps) {
  return mps.squaredNorm() < 1e10;
}

[[nodiscard]] inline bool plausible(const RangeEpoch& e) {
  return std::any_of(e.satellites.begin(), e.satellites.end(),
                     [](const CorrectedRange& s) { return has_range(s) || has_rate(s); });
}

[[nodiscard]] inline bool plausible(const GnssFix& f) {
  return is_on_earth(f.position) && is_positive_definite(f.position_covariance_ned_m2) &&
         (!f.velocity_ned_mps || (plausible_velocity(*f.velocity_ned_mps) &&
                                  is_positive_definite(f.velocity_covariance_ned)));
}

[[nodiscard]] inline bool plausible(const WheelSpeed& s) { return std::abs(s.speed_mps) < 1000.0; }

[[nodiscard]] inline bool plausible(const GnssInsStart& s) {
  const auto sigma = [](double value) { return value >= 0.0 && std::isfinite(value * value); };
  return is_on_earth(s.nav.position) && plausible_velocity(s.nav.velocity_ned_mps) &&
         s.nav.q_nb.quaternion().coeffs().allFinite() && s.gyro_bias_radps.allFinite() &&
         sigma(s.position_sigma_m) && sigma(s.velocity_sigma_mps) && sigma(s.level_sigma_rad) &&
         sigma(s.heading_sigma_rad) && sigma(s.gyro_bias_sigma_radps);
}

}  // namespace wayfare::nav
