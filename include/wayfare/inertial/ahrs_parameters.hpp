#pragma once

#include <limits>

#include <Eigen/Core>

#include <wayfare/core/angle.hpp>

namespace wayfare {

/// What the attitude filter takes for granted. Densities of white noise are standard deviations
/// after one second of averaging. The defaults suit a MEMS unit on a hand, a limb or a head.
struct AhrsParameters {
  /// Gyro noise, rad/s/√Hz. Larger than a data sheet's: it also stands for what the model leaves
  /// out. Larger trusts accelerometer and magnetometer more.
  double rate_noise = 0.3 * kDegree;
  /// Gyro noise that grows with the rate (scale, alignment, timing), √s: a scale error of standard
  /// deviation s and correlation time τ gives s·√(2τ).
  double rate_scale_noise = 0.003;
  /// Walk of the gyro bias, rad/s/√s, and its standard deviation at the start, rad/s.
  double bias_walk = 0.002 * kDegree;
  double bias_sigma = 1.0 * kDegree;
  /// Accelerometer noise, m/s²/√Hz.
  double force_noise = 0.02;

  /// The body's horizontal velocity is a first-order Gauss-Markov process with mean zero: its
  /// correlation time, s, and its density, m/s·√s (a walk of its integral; σ√(2τ)). Smaller holds
  /// on to the plumb line more, larger bears longer accelerations.
  double velocity_time_s = 0.1;
  double velocity_density = 0.4;

  bool use_magnetometer = true;
  /// Of magnetic north from true north, clockwise. Zero gives magnetic headings.
  Angle declination;
  /// Error of the magnetic heading as white noise, rad·√s: an error of standard deviation s and
  /// correlation time τ gives s·√(2τ).
  double heading_density = 10.0 * kDegree;
  /// How long after the field the magnetometer's reading is stamped, s, and how far that may be
  /// off; the filter finds the rest. Zero for the latter holds it fixed.
  double magnetometer_delay_s = 0.0;
  double magnetometer_delay_sigma_s = 0.02;
  /// A field is the Earth's where its strength is within this part of the known one, and its dip
  /// within this angle …
  double field_norm_gate = 0.1;
  Angle field_dip_gate = Angle::degrees(10.0);
  /// … for at least this long, s.
  double field_settle_s = 1.0;
  /// Another field that lasts this long, s, or as long as the first was known, while the body turns
  /// is taken for the Earth's.
  double field_relearn_s = 20.0;
  /// The Earth's field, µT, and its dip below the horizon; NaN: learned from the first readings.
  double field_norm_uT = std::numeric_limits<double>::quiet_NaN();
  Angle field_dip;

  /// Headings told from outside are of this axis of the body …
  Eigen::Vector3d heading_axis = Eigen::Vector3d::UnitX();
  /// … and may come so late, s; zero: none are taken, and nothing is kept for them.
  double heading_history_s = 0.0;
  /// Those off by more standard deviations than this are refused, unless they are off alike for
  /// `lost_heading_s`.
  double heading_gate_sigmas = 4.0;

  /// At rest is who keeps rate (rad/s) and specific force (m/s²) this near to their averages for
  /// this long, s, and whose average rate could be a bias (rad/s).
  double rest_rate = 2.0 * kDegree;
  double rest_force = 0.5;
  double rest_time_s = 1.5;
  double rest_bias_limit = 3.0 * kDegree;
  /// Noise of the rate, rad/s/√Hz, and of the velocity, m/s·√s, while at rest.
  double rest_rate_density = 0.03 * kDegree;
  double rest_velocity_density = 0.01;

  /// A component from here on is saturated: rad/s, m/s², µT. For units of ±2000 °/s and ±16 g.
  double rate_range = 34.8;
  double force_range = 156.0;
  double field_range = 5000.0;
  /// What a saturated sensor leaves out, as part of its reading.
  double saturated_part = 0.3;

  /// A longer pause of the gyro than the first, s, adds to the uncertainty, than the second starts
  /// the attitude anew (the bias is kept).
  double coarse_gap_s = 0.05;
  double restart_gap_s = 1.0;
  /// Horizontal acceleration, m/s², that no motion sustains for a second: the attitude is wrong and
  /// levelled anew. The second holds at rest.
  double lost_level = 4.0;
  double lost_level_at_rest = 1.0;
  /// A magnetic heading that differs by more than this for this long, s, is taken as it is.
  Angle lost_heading = Angle::degrees(30.0);
  double lost_heading_s = 10.0;

 private:
  static constexpr double kDegree = 0.017453292519943295;
};

}  // namespace wayfare
