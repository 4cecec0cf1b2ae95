#pragma once

// Parameters, poses and reports of pedestrian dead reckoning and of the foot tracker.

#include <cstdint>

#include <Eigen/Core>

#include <wayfare/core/angle.hpp>
#include <wayfare/core/se3.hpp>
#include <wayfare/inertial/ahrs_parameters.hpp>
#include <wayfare/inertial/attitude.hpp>
#include <wayfare/pedestrian/detail/magnetic_heading_drift.hpp>
#include <wayfare/pedestrian/detail/mean_field_north.hpp>
#include <wayfare/pedestrian/detail/straight_walk.hpp>
#include <wayfare/pedestrian/step.hpp>
#include <wayfare/pedestrian/step_detector.hpp>
#include <wayfare/sensors/trajectory.hpp>

namespace wayfare {

/// Source of the walking direction.
enum class WalkingAxis {
  sensor,     ///< an axis of the sensor, as held in the hand or worn on head, chest or hip
  principal,  ///< estimated from the body's sway: any mounting
};

/// For attitude indoors with a gyro whose bias was removed, as phones do: the field is disturbed
/// everywhere, so every reading is used with a low weight.
[[nodiscard]] inline AhrsParameters indoor_ahrs_parameters() {
  AhrsParameters p;
  p.bias_sigma *= 0.03;
  p.heading_density *= 2.0;
  p.field_norm_gate = 1.0;
  p.field_dip_gate = Angle::degrees(90.0);
  return p;
}

/// For a person known to walk, if only a few steps between pauses; all-day step counting requires
/// more in a row.
[[nodiscard]] inline StepParameters walking_step_parameters() {
  StepParameters p;
  p.least_steps = 4;
  return p;
}

/// `Length`: a StepLengthModel.
template <class Length>
struct BasicPedestrianParameters {
  StepParameters steps = walking_step_parameters();  ///< of the step detector
  Length length{};                                   ///< model of the step length
  AhrsParameters ahrs = indoor_ahrs_parameters();    ///< of the attitude
  WalkingAxis axis = WalkingAxis::sensor;            ///< source of the walking direction
  /// The sensor's axis along the walking direction; y on a phone.
  Eigen::Vector3d forward = Eigen::Vector3d::UnitY();
  /// Averaging time of the heading before a step, s: heads and hands turn to and fro.
  double heading_time_s = 0.5;
  /// Relative standard deviations of each step's length, and of the common scale.
  double length_sigma = 0.1;
  double length_scale_sigma = 0.06;  ///< of the common scale
  /// Standard deviations of each step's direction, and of the common offset, rad; in addition to
  /// the attitude's.
  double direction_sigma = 0.1;
  double direction_offset_sigma = 0.15;  ///< of the common offset
  /// Removes heading drift assuming straight segments. Helps on straight paths, harms on long
  /// bends; for units without magnetometer whose bias was not removed.
  StraightWalkParameters straight;
  /// Removes heading drift by an uncalibrated magnetometer; headings are then relative to the
  /// start.
  MagneticHeadingDriftParameters magnetic_drift;
  /// Headings by the gyro alone, and north by the mean field of the walk so far: at each step the
  /// whole path turns about its start. For walks of minutes inside buildings with a calibrated
  /// magnetometer; not as odometry. Not with magnetic_drift.
  MeanFieldNorthParameters mean_field;
};
/// With a model of the library.
using PedestrianParameters = BasicPedestrianParameters<StepLength>;
template <class Length>
class BasicPedestrian;
using Pedestrian = BasicPedestrian<StepLength>;  ///< with a model of the library

/// Pose after a step. World axes: x east, y north with a magnetometer, else from the start.
struct PedestrianPose {
  LogTime time;                                          ///< of the step's crest
  Eigen::Vector2d position_m = Eigen::Vector2d::Zero();  ///< m, from the start
  Angle heading;                                         ///< of walking, counter-clockwise from x
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< x, y in m, heading in rad
  Step step{};                                           ///< the step
  double length_m = 0.0;                                 ///< of the step

  /// Position and heading as odometry.
  [[nodiscard]] OdometrySample odometry() const {
    return {time,
            Transform2<frame::Odom, frame::Base>(SE2d(position_m.x(), position_m.y(), heading))};
  }
};

/// Counts of readings and steps.
struct PedestrianReport {
  AhrsReport ahrs;                    ///< of the readings
  std::uint64_t steps = 0;            ///< reported
  std::uint64_t without_heading = 0;  ///< steps before the attitude was initialised
  double distance_m = 0.0;            ///< sum of the lengths
  std::uint64_t without_length = 0;   ///< steps whose length was not finite
};

/// Stance statistics (Skog et al. 2010).
enum class StanceStatistic {
  shoe,  ///< specific force deviating from gravity, and angular rate
  ared,  ///< angular rate energy alone
};

/// Parameters of the foot-mounted filter, one setting for every gait and speed. White-noise
/// densities are standard deviations after one second.
struct FootParameters {
  double gravity_mps2 = 9.80665;  ///< at the place of the walk

  StanceStatistic statistic = StanceStatistic::shoe;  ///< of the stance: SHOE or ARED
  /// The statistic's window, s, and the standard deviations of force (m/s²) and rate (rad/s).
  double stance_window_s = 0.06;
  double stance_force_sigma = 0.2;  ///< of the force in a stance, m/s²; larger: more stances
  double stance_rate_sigma = 0.1;   ///< of the rate in a stance, rad/s; larger: more stances
  /// A stance is a minimum of the statistic within ± this time, s: errors within one stance are
  /// correlated and used once. Poses are delayed by this time.
  double stance_apart_s = 0.45;

  /// Standard deviation of the speed in a perfect stance, m/s; it grows with the square root of the
  /// statistic, since the sensor rotates about the contact point. Stances above the limit are
  /// ignored.
  double stance_speed = 0.01;
  double stance_speed_limit = 1.0;  ///< above it a stance is ignored, m/s
  /// Standard deviation of the velocity in motion, m/s. The filter weighs the hypotheses by its own
  /// velocity: a slowly lifted foot is as quiet as a standing one.
  double moving_speed = 3.0;
  /// Below this statistic the prior odds of stance are this power of the ratio.
  double quiet_statistic = 10.0;
  double quiet_power = 3.0;  ///< power of that ratio
  /// A height change between stances below the first, m, is zero to within the second, m (standard
  /// deviation): floors are level and stairs are higher. Zero for the first disables this.
  double level_step_m = 0.08;
  double level_sigma_m = 0.01;  ///< of a level floor between two stances

  double rate_noise = 0.00175;        ///< white noise of the gyro, rad/s/√Hz
  double rate_scale_noise = 0.0003;   ///< relative to the rate, √s
  double rate_jump_noise = 0.3;       ///< of the change from reading to reading
  double force_noise = 0.02;          ///< white noise of the accelerometer, m/s²/√Hz
  double force_scale_noise = 0.0007;  ///< relative to the acceleration, √s
  double force_jump_noise = 0.3;      ///< of the change from reading to reading
  double saturated_part = 0.5;        ///< error of a saturated reading, as a fraction of it

  double rate_bias_sigma = 0.0018;   ///< initial, rad/s
  double rate_bias_walk = 2.0e-5;    ///< of the gyro bias, rad/s/√s
  double force_bias_sigma = 0.2;     ///< initial, m/s²
  double force_bias_walk = 5.0e-4;   ///< of the accelerometer bias, m/s²/√s
  double start_tilt_sigma = 0.0175;  ///< initial, at rest, rad; ten times this in motion

  /// Below this statistic for this time, s, the foot is at rest and the gyro measures its bias.
  double rest_statistic = 0.5;
  double rest_time_s = 0.5;  ///< of low statistics before the foot is at rest
  /// Standard deviation of the mean rate over a tenth of a second from the bias, as a fraction of
  /// the rate's root mean square.
  double rest_rate_part = 3.0;

  /// A component of at least this magnitude is saturated: rad/s and m/s². For units of ±2000 °/s
  /// and ±16 g.
  double rate_range = 34.8;
  double force_range = 156.0;  ///< of the accelerometer, m/s²
  /// After a longer gap, s, the velocity is unknown.
  double longest_gap_s = 0.1;
  /// After this time without an accepted stance, s, velocity and tilt are reset.
  double lost_after_s = 5.0;
};

/// The foot at one reading. World axes: z up, origin at the start, x and y from the sensor's
/// initial heading.
struct FootPose {
  LogTime time;                                                      ///< of the reading
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();              ///< m
  Eigen::Vector3d velocity_mps = Eigen::Vector3d::Zero();            ///< m/s
  SO3d q_world_foot;                                                 ///< attitude, z up
  Eigen::Matrix3d position_covariance_m2 = Eigen::Matrix3d::Zero();  ///< of the position
  Angle heading;           ///< change since the start, counter-clockwise
  double statistic = 0.0;  ///< of stance
  double stance = 0.0;     ///< probability of a stance detected here; zero in between

  /// Position in the plane and heading as odometry.
  [[nodiscard]] OdometrySample odometry() const {
    return {time,
            Transform2<frame::Odom, frame::Base>(SE2d(position_m.x(), position_m.y(), heading))};
  }
};

/// Counts of readings by status, stances and faults.
struct FootReport {
  SensorReport gyro,           ///< readings by status
      accelerometer;           ///< readings by status
  std::uint64_t stances = 0;   ///< accepted: probability above one half
  std::uint64_t rejected = 0;  ///< quiet, but contradicted by the filter's velocity
  std::uint64_t gaps = 0;      ///< that left the velocity unknown
  std::uint64_t lost = 0;      ///< resets of velocity and tilt
};

}  // namespace wayfare
