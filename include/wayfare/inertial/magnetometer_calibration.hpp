#pragma once

// Hard and soft iron of a magnetometer from a recording of it being turned about: the readings of a
// constant field lie on an ellipsoid.

#include <cstddef>
#include <limits>
#include <span>

#include <Eigen/Core>

#include <wayfare/core/result.hpp>

namespace wayfare {

struct MagnetometerCalibrationOptions {
  /// Strength of the field the readings are brought to, µT; NaN: the ellipsoid's mean radius, so
  /// that the correction changes directions and not the scale.
  double field_uT = std::numeric_limits<double>::quiet_NaN();
  /// A reading counts that differs by this part of its strength from the one that counted before,
  /// so that a long rest does not outweigh the turning.
  double least_change = 0.05;
  std::size_t least_readings = 50;
  /// Of the directions the field was seen in, the smallest mean square along any axis: ⅓ for all
  /// alike, 0 where they lie in a plane.
  double least_spread = 0.05;
  /// Largest standard deviation of an offset, of the field's strength.
  double largest_offset_sigma = 0.05;
};

/// calibrated = correction·(raw − offset).
struct MagnetometerCalibration {
  Eigen::Vector3d offset_uT = Eigen::Vector3d::Zero();
  Eigen::Matrix3d correction = Eigen::Matrix3d::Identity();  ///< symmetric
  Eigen::Vector3d offset_sigma_uT = Eigen::Vector3d::Zero();
  Eigen::Matrix3d correction_sigma = Eigen::Matrix3d::Zero();
  double field_uT = 0.0;         ///< strength of the calibrated field
  double residual_uT = 0.0;      ///< standard deviation of its strength
  double raw_residual_uT = 0.0;  ///< the same of the raw readings
  double spread = 0.0;           ///< see MagnetometerCalibrationOptions::least_spread
  std::size_t used = 0;

  [[nodiscard]] Eigen::Vector3d operator()(const Eigen::Vector3d& raw_uT) const {
    return correction * (raw_uT - offset_uT);
  }
};

/// Readings in the sensor's axes, µT, NaN or zero where there is none. Errors: `degenerate` where
/// the sensor was turned too little to tell, `invalid` where the readings lie on no ellipsoid.
[[nodiscard]] Result<MagnetometerCalibration> calibrate_magnetometer(
    std::span<const Eigen::Vector3d> readings, const MagnetometerCalibrationOptions& options = {});

}  // namespace wayfare
