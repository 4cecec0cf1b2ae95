#pragma once

// Bearing correction of a moving radar with time-division multiplexing.

#include <algorithm>
#include <cmath>

#include <Eigen/Core>

#include <wayfare/sensors/scans.hpp>

namespace wayfare {

/// The virtual antenna row whose transform gives the bearings, half a wavelength apart: every
/// transmitter with all receivers, one transmitter after the other, the first one's to the left.
struct RadarArray {
  double max_speed_m_s = 0.0;  ///< radial speeds wrap here; 0: unknown, no correction
  int transmitters = 2;
  int receivers = 4;
  /// Points with a larger Doppler mismatch, as a fraction of max_speed_m_s, are not corrected.
  double max_mismatch = 0.25;

  /// Error of the bearing's sine per m/s of radial speed off the centre of its Doppler bin. The
  /// device compensates a point's motion between transmitters (Bechter, Roos and Waldschmidt 2017)
  /// with the speed of the bin; a phase of π δv / (T v_max) per transmitter remains. The transform
  /// interprets the slope of these steps, R(T² − 1)/(T²R² − 1) of a step for each of the TR
  /// antennas, as a bearing.
  [[nodiscard]] double sine_per_m_s() const {
    const double T = transmitters, R = receivers;
    if (!(max_speed_m_s > 0.0) || transmitters < 2) return 0.0;
    return R * (T * T - 1.0) / (T * T * R * R - 1.0) / (T * max_speed_m_s);
  }
};

/// `point` on a static object, measured by a radar that moves with `velocity_m_s` (its own axes),
/// with its bearing corrected to that of a radar at rest.
[[nodiscard]] inline RadarPoint compensate_bearing(const RadarPoint& point,
                                                   const Eigen::Vector2d& velocity_m_s,
                                                   const RadarArray& array) {
  const double x = point.x_m, y = point.y_m, range = std::hypot(x, y);
  const double per_m_s = array.sine_per_m_s();
  if (per_m_s == 0.0 || !(range > 0.0) || !std::isfinite(point.doppler_m_s)) return point;
  const double radial = -(velocity_m_s.x() * x + velocity_m_s.y() * y) / range;
  const double mismatch =
      std::remainder(radial - static_cast<double>(point.doppler_m_s), 2.0 * array.max_speed_m_s);
  if (!(std::abs(mismatch) <= array.max_mismatch * array.max_speed_m_s)) return point;
  const double sine = std::clamp(y / range - per_m_s * mismatch, -1.0, 1.0);
  RadarPoint corrected = point;
  corrected.x_m = static_cast<float>(std::copysign(range * std::sqrt(1.0 - sine * sine), x));
  corrected.y_m = static_cast<float>(range * sine);
  return corrected;
}

}  // namespace wayfare
