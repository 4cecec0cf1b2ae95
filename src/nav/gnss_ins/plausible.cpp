#include "nav/gnss_ins/plausible.hpp"

#include <algorithm>
#include <cmath>

namespace wayfare::nav {

bool plausible(const ImuSample& s) {
  return s.angular_rate_radps.allFinite() && s.specific_force_mps2.allFinite() &&
         s.angular_rate_radps.cwiseAbs().maxCoeff() < 200.0 &&
         s.specific_force_mps2.cwiseAbs().maxCoeff() < 5000.0;
}

bool plausible(const RangeEpoch& e) {
  return std::any_of(e.satellites.begin(), e.satellites.end(), [](const CorrectedRange& s) {
    return (std::isfinite(s.range_m) || std::isfinite(s.range_rate_mps)) &&
           s.position_ecef_m.allFinite();
  });
}

bool plausible(const GnssFix& f) {
  const auto positive = [](const Eigen::Matrix3d& m) {
    return m.allFinite() && (m.diagonal().array() > 0.0).all();
  };
  return std::isfinite(f.position.latitude.radians()) &&
         std::isfinite(f.position.longitude.radians()) && std::isfinite(f.position.height_m) &&
         std::abs(f.position.latitude.degrees()) <= 90.0 &&
         positive(f.position_covariance_ned_m2) &&
         (!f.velocity_ned_mps ||
          (f.velocity_ned_mps->allFinite() && positive(f.velocity_covariance_ned)));
}

}  // namespace wayfare::nav
