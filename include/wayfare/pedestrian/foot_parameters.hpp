#pragma once

// What the foot tracker hands out.

#include <cstdint>

#include <Eigen/Core>

#include <wayfare/core/angle.hpp>
#include <wayfare/core/so3.hpp>
#include <wayfare/inertial/attitude.hpp>
#include <wayfare/sensors/trajectory.hpp>

namespace wayfare {

/// Which statistic tells a foot that stands from one that moves (Skog et al. 2010).
enum class StanceStatistic {
  shoe,  ///< force off gravity, and turning
  ared,  ///< turning alone: angular rate energy
};

/// What the foot-mounted filter takes for granted. One setting for every gait: nothing here says
/// how fast one walks. Densities of white noise are standard deviations after one second.
struct FootParameters {
  double gravity_mps2 = 9.80665;

  StanceStatistic statistic = StanceStatistic::shoe;
  /// The statistic's window, s, and what force (m/s²) and rate (rad/s) are measured in.
  double stance_window_s = 0.06;
  double stance_force_sigma = 0.2;
  double stance_rate_sigma = 0.1;
  /// A foot may stand where the statistic is smallest within this time to either side, s: errors
  /// within one stance are one error, to be used once. Answers come later by as much.
  double stance_apart_s = 0.45;

  /// Speed, m/s, of a foot that stands as still as the statistic can tell; it grows with the
  /// statistic's root, for the sensor turns about where the sole touches. Where it would be larger
  /// than the limit nothing is learned.
  double stance_speed = 0.01;
  double stance_speed_limit = 1.0;
  /// Where the foot does not stand, its velocity may be anything of this deviation, m/s. Which of
  /// the two it is the filter judges by its own velocity: a foot lifted slowly is as quiet as one
  /// that stands.
  double moving_speed = 3.0;
  /// Below this statistic standing is likelier beforehand, with this power of the ratio.
  double quiet_statistic = 10.0;
  double quiet_power = 3.0;
  /// From stance to stance a height that changed by less than the first, m, is the same height to
  /// within the second: floors are level and stairs are higher. Zero for the first: no such rule.
  double level_step_m = 0.08;
  double level_sigma_m = 0.01;

  double rate_noise = 0.00175;        ///< rad/s/√Hz
  double rate_scale_noise = 0.0003;   ///< of the rate, √s
  double rate_jump_noise = 0.3;       ///< of the change from reading to reading
  double force_noise = 0.02;          ///< m/s²/√Hz
  double force_scale_noise = 0.0007;  ///< of the acceleration, √s
  double force_jump_noise = 0.3;      ///< of the change from reading to reading
  double saturated_part = 0.5;        ///< of a saturated reading that may be missing

  double rate_bias_sigma = 0.0018;   ///< at the start, rad/s
  double rate_bias_walk = 2.0e-5;    ///< rad/s/√s
  double force_bias_sigma = 0.2;     ///< at the start, m/s²
  double force_bias_walk = 5.0e-4;   ///< m/s²/√s
  double start_tilt_sigma = 0.0175;  ///< of an attitude taken at rest, rad; ten times it in motion

  /// Below this statistic for so long, s, the foot is at rest: the gyro shows its bias.
  double rest_statistic = 0.5;
  double rest_time_s = 0.5;
  /// How far the mean rate over a tenth of a second may be from the bias, as part of its root mean
  /// square.
  double rest_rate_part = 3.0;

  /// A component from here on is saturated: rad/s and m/s². For units of ±2000 °/s and ±16 g.
  double rate_range = 34.8;
  double force_range = 156.0;
  /// A longer pause, s, leaves the velocity unknown.
  double longest_gap_s = 0.1;
  /// So long without a stance that could be believed, s, and the velocity is taken anew.
  double lost_after_s = 5.0;
};

/// The foot at one reading. World axes: z up, origin where it began, x and y as the sensor stood.
struct FootPose {
  LogTime time;
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d velocity_mps = Eigen::Vector3d::Zero();
  SO3d q_world_foot;
  Eigen::Matrix3d position_covariance_m2 = Eigen::Matrix3d::Zero();
  Angle heading;           ///< turned since the start, about the vertical, counter-clockwise
  double statistic = 0.0;  ///< of standing, by FootParameters::statistic
  double stands = 0.0;     ///< probability given to a stance found here; zero in between

  [[nodiscard]] OdometrySample odometry() const {
    return {time,
            Transform2<frame::Odom, frame::Base>(SE2d(position_m.x(), position_m.y(), heading))};
  }
};

/// What became of the readings, and what went wrong on the way.
struct FootReport {
  SensorReport gyro, accelerometer;
  std::uint64_t stances = 0;  ///< believed more than not
  std::uint64_t doubted = 0;  ///< quiet, but against the filter's own velocity
  std::uint64_t gaps = 0;     ///< pauses that left the velocity unknown
  std::uint64_t lost = 0;     ///< times velocity or attitude was taken anew
};

}  // namespace wayfare
