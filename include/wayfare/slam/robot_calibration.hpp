#pragma once

// Calibration of a robot on two driven wheels from one drive: wheel sizes and base, mounting and
// time offset of a laser and of a radar, scale, bias and time offset of a gyro.
//
// Motions of the laser come from scan matching, those of the radar from the radial speeds of each
// frame; with the wheels' motion W and a mounting X they are X⁻¹ W X and the velocity of a point of
// the base (Censi, Franchi, Marchionni and Oriolo 2013, "Simultaneous calibration of odometry and
// sensor parameters for mobile robots"). All parameters are solved for together, by least squares
// with robust kernels on a factor graph; the noise of each sensor is that of its residuals.
//
// What the drive does not determine is reported as such: on a straight line neither the wheel base
// nor a lever arm has any effect.

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include <wayfare/core/angle.hpp>
#include <wayfare/core/result.hpp>
#include <wayfare/core/se2.hpp>
#include <wayfare/motion/radar_velocity.hpp>
#include <wayfare/sensors/recording.hpp>
#include <wayfare/slam/scan_outcome.hpp>

namespace wayfare {

/// A parameter is determined where its standard deviation is at most these.
struct CalibrationLimits {
  double position_m = 0.02;         ///< of each coordinate of a lever arm
  Angle yaw = Angle::degrees(0.5);  ///< of a mounting
  double delay_s = 0.005;           ///< between the clocks of two sensors
  double wheel_scale = 0.005;       ///< of each wheel's size, relative
  double wheel_base = 0.01;         ///< relative
  double gyro_scale = 0.01;         ///< relative
  double gyro_bias_rad_s = 0.001;   ///< of a gyro at rest, rad/s
};

/// Limits, noise and robustness of calibrate_robot.
struct RobotCalibrationOptions {
  CalibrationLimits limits{};  ///< of what counts as determined
  /// Of each radar frame. The largest residual of an inlier covers two Doppler bins of 0.12 m/s:
  /// echoes leak into the bins beside theirs, and with some of these cut off speeds are biased.
  RadarVelocityOptions velocity{.plane = true, .inlier_m_s = 0.3};
  double slip_m_per_sqrt_m = 0.006;  ///< of each wheel: weights of the motions before the first fit
  double kernel_sigmas = 2.5;        ///< scale of the Cauchy kernel, in standard deviations
  /// Largest time offset that is searched for, s, to either side.
  double max_delay_s = 0.5;
  /// Between wheel samples further apart than this the motion is unknown, s.
  double largest_gap_s = 0.35;
  /// Travel and heading change of the laser between the scans of one motion.
  double motion_m = 0.1;
  Angle motion_turn = Angle::degrees(6.0);  ///< heading change
  /// Residuals within this time have common causes: the covariance is that of the sums over such
  /// blocks where it is larger (sandwich estimator for clustered data, Liang and Zeger 1986), s.
  double block_s = 4.0;
};

/// One number of a calibration.
struct CalibratedParameter {
  std::string name;         ///< "radar.yaw", "wheels.base": sensor and parameter
  std::string unit;         ///< "m", "rad", "s", "rad/s", or empty for a ratio
  double given = 0.0;       ///< before: of the recording
  double value = 0.0;       ///< estimate; equal to `given` where it is not determined
  double sigma = 0.0;       ///< standard deviation; infinite where the drive says nothing
  bool determined = false;  ///< sigma is within CalibrationLimits
};

/// What a sensor contributed.
struct CalibratedSensor {
  std::string name;              ///< "laser", "radar", "gyro"
  std::size_t measurements = 0;  ///< motions or velocities
  std::size_t outliers = 0;      ///< of these, beyond three standard deviations
  /// Their noise relative to what was expected of matches, frames and slip.
  double noise = 1.0;
};

/// Result of calibrate_robot.
///
/// Names: "wheels.left_scale", "wheels.right_scale" (metres rolled per metre reported) and
/// "wheels.base"; for "laser" and "radar" ".x", ".y", ".yaw" (pose in the base: the middle of the
/// axle, x in the direction of rolling) and ".delay" (stamps late against those of the wheels);
/// "gyro.scale" (rate reported per rate turned), "gyro.bias" and "gyro.delay". With both sensors
/// "laser_to_radar.x" and so on: the radar's pose in the laser's frame, and its delay less the
/// laser's. Without wheels the base is the laser, and its clock that of reference.
struct RobotCalibration {
  std::vector<CalibratedParameter> parameters;  ///< in this order
  /// Of the parameters, in their order and units; rows of those not determined are large, and
  /// follow from a vague prior.
  Eigen::MatrixXd covariance;
  std::vector<CalibratedSensor> sensors;  ///< that have measurements
  std::vector<std::string> notes;         ///< sensors without data, gaps, mountings far from given

  /// Null for a name that was not calibrated.
  [[nodiscard]] const CalibratedParameter* find(std::string_view name) const;
  /// Names of those not determined.
  [[nodiscard]] std::vector<std::string> undetermined() const;
  /// `recording` with the parameters that are determined: mountings, wheel base, distances of the
  /// wheels, gyro rates, stamps. Odometry is of the calibrated wheels where there are any.
  [[nodiscard]] Recording applied_to(Recording recording) const;
};

/// Calibrates all sensors of `recording` that say something of each other: wheels with laser,
/// radar and gyro, or laser with radar and gyro. Mountings and wheel base of the recording are the
/// values given. Errors: fewer than two sensors (not_found), hardly any motion (degenerate), and
/// units, signs or sides of one that contradict another (invalid), with the likely cause.
[[nodiscard]] Result<RobotCalibration> calibrate_robot(const Recording& recording,
                                                       const RobotCalibrationOptions& options = {},
                                                       const SlamProgress& progress = {});

}  // namespace wayfare
