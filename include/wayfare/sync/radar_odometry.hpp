#pragma once

// Odometry of a robot on two driven wheels by its wheels, gyro and the radial speeds of a radar's
// frames: wheels that slip are replaced while they do, wheels that are missing all the time. The
// radar's speed has an error of scale of some per cent; it is estimated while the wheels roll.

#include <cstddef>
#include <vector>

#include <wayfare/core/detail/eigen_alignment.hpp>
#include <wayfare/motion/radar_velocity.hpp>
#include <wayfare/sensors/recording.hpp>

namespace wayfare {

/// Noise and slip detection of radar_odometry.
struct RadarOdometryOptions {
  /// Of each frame; inliers within two Doppler bins of 0.12 m/s and a bit: fewer bias it.
  RadarVelocityOptions velocity{.plane = true, .inlier_m_s = 0.3};
  /// Standard deviation of each wheel's distance after one metre without slipping.
  double wheel_noise_m_per_sqrt_m = 0.006;
  double side_sigma_m_s = 0.01;  ///< standard deviation of the base's speed to the side, m/s
  double longest_hold_s = 0.3;   ///< how long a velocity is used without another frame
  double largest_gap_s = 0.3;    ///< between wheel samples further apart they are silent
  double period_s = 0.05;        ///< of the samples where there are no wheels
  double wheel_base_m = 0.4;     ///< where the recording has none
  /// Wheels slip where the mean difference of their speed to the radar's, over about `slip_time_s`,
  /// exceeds `slip_sigmas` standard deviations, a share of the speed and a constant together; or
  /// that of their turn rate to the gyro's. Larger: fewer false alarms, slip believed for longer.
  double slip_time_s = 0.4;       ///< slip is noticed up to twice this after it begins
  double slip_sigmas = 4.0;       ///< of the mean difference
  double slip_share = 0.08;       ///< of the wheels' speed or turn rate
  double slip_m_s = 0.01;         ///< m/s
  double slip_turn_rad_s = 0.08;  ///< rad/s
  /// Standard deviation of the ratio of the radar's speed to the wheels' before any is known.
  double scale_sigma = 0.03;
  double scale_walk_per_sqrt_s = 0.001;  ///< standard deviation of its change in one second
};

/// Distances rolled, and how they were found.
struct RadarOdometry {
  /// As if rolled without slip on wheels `wheel_base_m` apart.
  std::vector<WheelSample> wheels;
  double wheel_base_m = 0.0;  ///< of the recording, or of the options
  std::size_t frames = 0,     ///< of the radar
      frames_without = 0;     ///< of these without a velocity
  double slipped_s = 0.0,     ///< time in which slipping wheels were replaced
      silent_s = 0.0,         ///< time in which missing wheels were replaced
      unknown_s = 0.0;        ///< time without wheels and radar: speed kept
  double radar_scale = 1.0,   ///< ratio of the radar's speed to the wheels' that rolled, at the end
      radar_scale_sigma = 0.0;  ///< its standard deviation
};

/// Wheels of the recording, corrected and completed by its radar and gyro; of the mounting and
/// wheel base in the recording. A distance depends on measurements up to twice `slip_time_s` after
/// it. Samples that are not finite count as missing. Without radar the wheels as they are.
[[nodiscard]] RadarOdometry radar_odometry(const Recording& recording,
                                           const RadarOdometryOptions& options = {});

/// `recording` with these wheels, and odometry from them with the gyro's heading where there is
/// one: for any system that uses wheels or odometry.
[[nodiscard]] Recording with_radar_odometry(Recording recording,
                                            const RadarOdometryOptions& options = {});

}  // namespace wayfare
