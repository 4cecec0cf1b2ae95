#pragma once

// Diagnosis of a recording of an inertial unit and a satellite receiver: units, signs, mounting and
// times of the unit, by comparison with the accelerations and course changes of the receiver.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include <wayfare/core/se3.hpp>
#include <wayfare/nav/gnss_ins.hpp>

namespace wayfare {

/// A likely fault of a recording or of its description.
struct DriveFinding {
  /// What is wrong.
  enum class Cause : std::uint8_t {
    no_overlap,       ///< the unit's times and the receiver's do not overlap
    time_offset,      ///< the unit's times are early or late
    force_unit,       ///< specific force in another unit
    no_gravity,       ///< specific force without gravity
    force_size,       ///< specific force of a wrong size, of no known unit
    rate_unit,        ///< angular rate in another unit
    rate_size,        ///< angular rate of a wrong size, of no known unit
    silent_gyro,      ///< angular rate is always zero
    mounting,         ///< the configured mounting differs from that of the data
    force_sign,       ///< accelerometer axes with the wrong sign
    rate_sign,        ///< gyro axes with the wrong sign
    axis_sign,        ///< axes of both with the wrong sign: a left-handed unit
    no_position,      ///< the receiver has no positions
    no_velocity,      ///< the receiver has no velocities
    at_rest,          ///< the vehicle does not move: the heading is unknown
    rejected,         ///< the filter rejects what GNSS alone accepts
    reinitialised,    ///< the filter lost its solution
    unknown_heading,  ///< the filter's heading stayed unknown
  };
  Cause cause = Cause::no_overlap;  ///< what is wrong
  std::string text;                 ///< the likely cause with its figures, one line
  std::string option;               ///< what to set or to provide
};

/// What the data tell of the unit. Empty: not observable.
struct DriveEstimate {
  double force_size_mps2 = 0.0;             ///< median size of the specific force as read
  std::optional<SO3d> q_body_imu;           ///< mounting; the heading needs accelerations
  double mounting_sigma_rad = 0.0;          ///< of its heading
  std::optional<Eigen::Vector3d> level;     ///< unit vector down at rest, the unit's corrected axes
  std::optional<double> imu_time_offset_s;  ///< in place of the configured one
  double time_offset_sigma_s = 0.0;         ///< of the offset
  std::optional<Eigen::Vector3d> antenna_lever_arm_m;  ///< body axes
  Eigen::Vector3d lever_arm_sigma_m =
      Eigen::Vector3d::Zero();  ///< of the lever arm; components above 0.3 m are as configured
  /// Factors that correct readings: unit and sign of each axis.
  Eigen::Vector3d gyro_factor = Eigen::Vector3d::Ones();
  Eigen::Vector3d accel_factor = Eigen::Vector3d::Ones();  ///< of the accelerometer
};

/// Findings of a recording, in order of importance, and what was estimated.
struct DriveCheck {
  std::vector<DriveFinding> findings;  ///< none: nothing speaks against the description
  DriveEstimate estimate;              ///< of the unit
};

/// Compares the unit with the receiver, in closed form: specific force by its size and direction;
/// axes by regression of the readings on the accelerations along and across the course and of the
/// course's rate on the gyros; handedness by the sign of their determinant; gyro signs by changes
/// of the tilt; time offset by the likelihood of these regressions over all offsets within 40 s, or
/// if none fits over all that overlap. The recording is in order of time. Values that are not
/// finite are left out.
[[nodiscard]] DriveCheck check_drive(const GnssInsRecording& recording,
                                     const GnssInsOptions& options);

/// The recording with the factors of the estimate applied to its readings.
[[nodiscard]] GnssInsRecording corrected(GnssInsRecording recording, const DriveEstimate& estimate);
/// The options with mounting, time offset and lever arm of the estimate where it has them.
[[nodiscard]] GnssInsOptions corrected(GnssInsOptions options, const DriveEstimate& estimate);

/// Refines mounting, time offset and lever arm by runs of the filter on the corrected recording:
/// the mounting by the direction of travel in the unit's axes, offset and lever arm by least
/// squares of the innovations (prediction error method: Ljung 1999, chapter 7). Unchanged where
/// the filter does not start.
void refine_estimate(const GnssInsRecording& recording, const GnssInsOptions& options,
                     DriveEstimate& estimate);

/// What a finished run tells: rejected measurements that agree among themselves, lost solutions,
/// and a heading that stayed unknown.
[[nodiscard]] std::vector<DriveFinding> check_run(const GnssInsRecording& recording,
                                                  const GnssInsResult& result);

}  // namespace wayfare
