#pragma once

// Hard and soft iron of a magnetometer from a recording of it being turned about: the readings of a
// constant field lie on an ellipsoid.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Eigenvalues>

#include <wayfare/core/result.hpp>
#include <wayfare/estimate/ellipsoid_fit.hpp>

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

namespace magnetometer {

using Readings = std::vector<Eigen::Vector3d>;

[[nodiscard]] inline Readings that_count(std::span<const Eigen::Vector3d> readings, double change) {
  Readings kept;
  for (const Eigen::Vector3d& m : readings) {
    if (!m.allFinite() || m.isZero()) continue;
    if (kept.empty() || (m - kept.back()).norm() >= change * m.norm()) kept.push_back(m);
  }
  return kept;
}

[[nodiscard]] inline double strength_deviation(const Readings& readings) {
  double sum = 0.0, squares = 0.0;
  for (const auto& m : readings) sum += m.norm(), squares += m.squaredNorm();
  const auto n = static_cast<double>(readings.size());
  return std::sqrt(std::max(0.0, squares / n - sum * sum / (n * n)));
}

[[nodiscard]] inline double spread_of_directions(const Readings& readings, const Ellipsoid& e) {
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  for (const auto& m : readings) {
    const Eigen::Vector3d u = (e.matrix * (m - e.centre)).normalized();
    scatter += u * u.transpose() / static_cast<double>(readings.size());
  }
  return Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(scatter).eigenvalues()[0];
}

[[nodiscard]] inline MagnetometerCalibration from_ellipsoid(const Ellipsoid& e, double field_uT) {
  MagnetometerCalibration c;
  c.field_uT = field_uT > 0.0 ? field_uT : 1.0 / std::cbrt(e.matrix.determinant());
  c.offset_uT = e.centre;
  c.correction = c.field_uT * e.matrix;
  const Eigen::Matrix<double, 9, 1> sigma = e.covariance.diagonal().cwiseSqrt();
  c.offset_sigma_uT = sigma.head<3>();
  c.correction_sigma << sigma[3], sigma[6], sigma[7], sigma[6], sigma[4], sigma[8], sigma[7],
      sigma[8], sigma[5];
  c.correction_sigma *= c.field_uT;
  c.residual_uT = c.field_uT * e.residual;
  return c;
}

}  // namespace magnetometer

/// Readings in the sensor's axes, µT, NaN or zero where there is none. Errors: `degenerate` where
/// the sensor was turned too little to tell, `invalid` where the readings lie on no ellipsoid.
[[nodiscard]] inline Result<MagnetometerCalibration> calibrate_magnetometer(
    std::span<const Eigen::Vector3d> readings, const MagnetometerCalibrationOptions& options = {}) {
  const auto kept = magnetometer::that_count(readings, options.least_change);
  const auto too_little = [](const std::string& what) {
    return Error{ErrorCode::degenerate,
                 what + "; turn the sensor slowly through all orientations, away from iron"};
  };
  if (kept.size() < options.least_readings)
    return too_little("the magnetometer was hardly turned: " + std::to_string(kept.size()) +
                      " different readings, " + std::to_string(options.least_readings) +
                      " are needed");
  const auto e = fit_ellipsoid(kept);
  if (!e) return too_little("the readings do not determine an ellipsoid");
  auto c = magnetometer::from_ellipsoid(*e, options.field_uT);
  c.used = kept.size();
  c.raw_residual_uT = magnetometer::strength_deviation(kept);
  c.spread = magnetometer::spread_of_directions(kept, *e);
  if (c.spread < options.least_spread)
    return too_little("the field was seen from too few sides: spread " + std::to_string(c.spread) +
                      ", at least " + std::to_string(options.least_spread) + " is needed");
  const double radius = 1.0 / std::cbrt(e->matrix.determinant());
  if (c.offset_sigma_uT.maxCoeff() > options.largest_offset_sigma * radius)
    return too_little("the offset is only known to " +
                      std::to_string(c.offset_sigma_uT.maxCoeff()) + " uT");
  if (!(e->residual < 0.2))
    return Error{ErrorCode::invalid,
                 "the readings do not lie on an ellipsoid: the field was not the same everywhere"};
  return c;
}

}  // namespace wayfare
