#pragma once

// Hard- and soft-iron calibration of a magnetometer rotated in a constant field: its readings lie
// on an ellipsoid.

#include <cstddef>
#include <limits>
#include <span>

#include <Eigen/Core>

#include <wayfare/core/detail/eigen_alignment.hpp>
#include <wayfare/core/result.hpp>

namespace wayfare {

/// Selection of readings and what a calibration must reach.
struct MagnetometerCalibrationOptions {
  /// Field strength after calibration, µT; NaN: the ellipsoid's mean radius, so that the correction
  /// changes directions and not the scale.
  double field_uT = std::numeric_limits<double>::quiet_NaN();
  /// A reading is used if it differs from the previous used one by this fraction of its strength,
  /// so that a long rest does not dominate.
  double least_change = 0.05;
  std::size_t least_readings = 50;  ///< fewer are an error
  /// Smallest eigenvalue of the second moment of the measured field directions: ⅓ for a uniform
  /// distribution, 0 for directions in a plane.
  double least_spread = 0.05;
  /// Largest standard deviation of an offset, as a fraction of the field strength.
  double largest_offset_sigma = 0.05;
};

/// calibrated = correction·(raw − offset).
struct MagnetometerCalibration {
  Eigen::Vector3d offset_uT = Eigen::Vector3d::Zero();         ///< hard iron, µT
  Eigen::Matrix3d correction = Eigen::Matrix3d::Identity();    ///< symmetric
  Eigen::Vector3d offset_sigma_uT = Eigen::Vector3d::Zero();   ///< standard deviation, each axis
  Eigen::Matrix3d correction_sigma = Eigen::Matrix3d::Zero();  ///< standard deviation, each element
  double field_uT = 0.0;                                       ///< strength of the calibrated field
  double residual_uT = 0.0;      ///< standard deviation of its strength
  double raw_residual_uT = 0.0;  ///< the same for the raw readings
  double spread = 0.0;           ///< see MagnetometerCalibrationOptions::least_spread
  std::size_t used = 0;          ///< number of readings

  /// The calibrated field, µT.
  [[nodiscard]] Eigen::Vector3d operator()(const Eigen::Vector3d& raw_uT) const {
    return correction * (raw_uT - offset_uT);
  }
};

/// Readings in the sensor's axes, µT, NaN or zero if missing. Errors: `degenerate` if the sensor
/// was rotated too little, `invalid` if the readings do not lie on an ellipsoid.
[[nodiscard]] Result<MagnetometerCalibration> calibrate_magnetometer(
    std::span<const Eigen::Vector3d> readings, const MagnetometerCalibrationOptions& options = {});

}  // namespace wayfare
