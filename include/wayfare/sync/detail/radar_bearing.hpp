#pragma once

// Bearings of a radar that moves while its transmitters take turns.

#include <algorithm>
#include <cmath>

#include <Eigen/Core>

#include <wayfare/sensors/radar_scan.hpp>

namespace wayfare {

/// The row of antennas whose transform gives the bearings, half a wavelength apart: every
/// transmitter with all receivers, one transmitter after the other, the first one's to the left.
struct RadarArray {
  double max_speed_m_s = 0.0;  ///< radial speeds wrap here; 0: not known, bearings stay
  int transmitters = 2;
  int receivers = 4;
  /// A point whose Doppler is off by more than this share of max_speed_m_s belongs to something
  /// that moves by itself, and stays.
  double largest_share = 0.25;

  /// Sine of the bearing that a radial speed beside its Doppler bin adds, per m/s. What a point
  /// moves from one transmitter to the next (Bechter, Roos and Waldschmidt 2017) the device turns
  /// back by the speed of the bin alone; a phase of π δv / (T v_max) for each transmitter remains.
  /// The transform takes the slope of these stairs, R(T² − 1)/(T²R² − 1) of a stair for each of the
  /// TR antennas, for a bearing.
  [[nodiscard]] double sine_per_m_s() const {
    const double T = transmitters, R = receivers;
    if (!(max_speed_m_s > 0.0) || transmitters < 2) return 0.0;
    return R * (T * T - 1.0) / (T * T * R * R - 1.0) / (T * max_speed_m_s);
  }
};

/// `point` of something at rest, seen by a radar that moves with `velocity_m_s` (its own axes),
/// with the bearing it would have been given at rest.
[[nodiscard]] inline RadarPoint bearing_set_right(const RadarPoint& point,
                                                  const Eigen::Vector2d& velocity_m_s,
                                                  const RadarArray& array) {
  const double x = point.x_m, y = point.y_m, range = std::hypot(x, y);
  const double per_m_s = array.sine_per_m_s();
  if (per_m_s == 0.0 || !(range > 0.0) || !std::isfinite(point.doppler_m_s)) return point;
  const double radial = -(velocity_m_s.x() * x + velocity_m_s.y() * y) / range;
  const double between =
      std::remainder(radial - static_cast<double>(point.doppler_m_s), 2.0 * array.max_speed_m_s);
  if (!(std::abs(between) <= array.largest_share * array.max_speed_m_s)) return point;
  const double sine = std::clamp(y / range - per_m_s * between, -1.0, 1.0);
  RadarPoint right = point;
  right.x_m = static_cast<float>(std::copysign(range * std::sqrt(1.0 - sine * sine), x));
  right.y_m = static_cast<float>(range * sine);
  return right;
}

}  // namespace wayfare
