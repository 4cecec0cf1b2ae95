#pragma once

// Parameters of the attitude and heading reference system.

#include <limits>
#include <numbers>

#include <Eigen/Core>

#include <wayfare/core/angle.hpp>
#include <wayfare/core/detail/eigen_alignment.hpp>

namespace wayfare {

/// Parameters of the attitude filter. White-noise densities are standard deviations after one
/// second of averaging. The defaults suit a MEMS unit on a hand, a limb or a head.
struct AhrsParameters {
  /// Gyro noise, rad/s/√Hz. Larger than the data sheet value, since it covers unmodelled errors.
  /// Larger values weight accelerometer and magnetometer more.
  double rate_noise = 0.3 * kDegree;
  /// Gyro noise proportional to the rate (scale, alignment, timing), √s: a scale error of standard
  /// deviation s and correlation time τ gives s·√(2τ).
  double rate_scale_noise = 0.003;
  /// Random walk of the gyro bias, rad/s/√s, and its initial standard deviation, rad/s.
  double bias_walk = 0.002 * kDegree;
  double bias_sigma = 1.0 * kDegree;  ///< initial standard deviation of the gyro bias, rad/s
  /// Accelerometer noise, m/s²/√Hz.
  double force_noise = 0.02;

  /// The body's horizontal velocity is a zero-mean first-order Gauss-Markov process: its
  /// correlation time, s, and density σ√(2τ), m/s·√s. Smaller values follow the measured gravity
  /// direction more closely, larger ones tolerate longer accelerations.
  double velocity_time_s = 0.1;
  double velocity_density = 0.4;  ///< σ√(2τ), m/s·√s; larger: tolerates longer accelerations

  bool use_magnetometer = true;  ///< else the heading is by the gyro alone
  /// Magnetic north from true north, clockwise. Zero gives magnetic headings.
  Angle declination{};
  /// Error of the magnetic heading as white noise, rad·√s: an error of standard deviation s and
  /// correlation time τ gives s·√(2τ).
  double heading_density = 10.0 * kDegree;
  /// Delay of the magnetometer's time stamps, s, and its initial standard deviation, s; the filter
  /// estimates it. A zero deviation keeps the delay fixed.
  double magnetometer_delay_s = 0.0;
  double magnetometer_delay_sigma_s = 0.02;  ///< initial, s; 0: the delay is fixed
  /// A field is accepted as the Earth's if its strength is within this fraction of the reference,
  /// and its dip within this angle …
  double field_norm_gate = 0.1;
  Angle field_dip_gate = Angle::degrees(10.0);  ///< largest deviation of the dip
  /// … for at least this long, s.
  double field_settle_s = 1.0;
  /// A different field that lasts this long, s, or as long as the reference was known, while the
  /// body turns becomes the new reference.
  double field_relearn_s = 20.0;
  /// The Earth's field, µT, and its dip below the horizon; NaN: learned from the first readings.
  double field_norm_uT = std::numeric_limits<double>::quiet_NaN();
  Angle field_dip{};  ///< below the horizon

  /// Body axis that external headings refer to …
  Eigen::Vector3d heading_axis = Eigen::Vector3d::UnitX();
  /// … and their greatest delay, s; zero: external headings are not used.
  double heading_history_s = 0.0;
  /// Gate for external headings, standard deviations; rejected ones that agree with each other for
  /// `lost_heading_s` reset the heading.
  double heading_gate_sigmas = 4.0;

  /// At rest: rate (rad/s) and specific force (m/s²) stay this close to their averages for this
  /// time, s, and the average rate could be a bias (rad/s).
  double rest_rate = 2.0 * kDegree;
  double rest_force = 0.5;                 ///< largest deviation of the force at rest, m/s²
  double rest_time_s = 1.5;                ///< for which both stay close before the body is at rest
  double rest_bias_limit = 3.0 * kDegree;  ///< largest mean rate that is taken for a bias, rad/s
  /// Noise of the rate, rad/s/√Hz, and of the velocity, m/s·√s, while at rest.
  double rest_rate_density = 0.03 * kDegree;
  double rest_velocity_density = 0.01;  ///< noise of the velocity at rest, m/s·√s

  /// A component of at least this magnitude is saturated: rad/s, m/s², µT. For units of ±2000 °/s
  /// and ±16 g.
  double rate_range = 34.8;
  double force_range = 156.0;   ///< of the accelerometer, m/s²
  double field_range = 5000.0;  ///< of the magnetometer, µT
  /// Error of a saturated reading as a fraction of its magnitude.
  double saturated_part = 0.3;

  /// A gyro gap longer than the first, s, increases the uncertainty; one longer than the second
  /// reinitialises the attitude (the bias is kept).
  double coarse_gap_s = 0.05;
  double restart_gap_s = 1.0;  ///< longest gap that the attitude survives
  /// Mean horizontal acceleration, m/s², that no motion sustains for a second: the attitude is
  /// wrong and is levelled again. The second applies at rest.
  double lost_level = 4.0;
  double lost_level_at_rest = 1.0;  ///< the same at rest, m/s²
  /// A magnetic heading that differs by more than this for this long, s, resets the heading.
  Angle lost_heading = Angle::degrees(30.0);
  double lost_heading_s = 10.0;  ///< before the heading is reset

 private:
  static constexpr double kDegree = std::numbers::pi / 180.0;
};

}  // namespace wayfare
