#include <wayfare/inertial/magnetometer_calibration.hpp>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <Eigen/Eigenvalues>

#include <wayfare/inertial/detail/ellipsoid_fit.hpp>

namespace wayfare {
namespace {

using Readings = std::vector<Eigen::Vector3d>;

Readings distinct(std::span<const Eigen::Vector3d> readings, double change) {
  Readings kept;
  for (const Eigen::Vector3d& m : readings) {
    if (!m.allFinite() || m.isZero()) continue;
    if (kept.empty() || (m - kept.back()).norm() >= change * m.norm()) kept.push_back(m);
  }
  return kept;
}

double strength_deviation(const Readings& readings) {
  double sum = 0.0, squares = 0.0;
  for (const auto& m : readings) sum += m.norm(), squares += m.squaredNorm();
  const auto n = static_cast<double>(readings.size());
  return std::sqrt(std::max(0.0, squares / n - sum * sum / (n * n)));
}

double spread_of_directions(const Readings& readings, const Ellipsoid& e) {
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  for (const auto& m : readings) {
    const Eigen::Vector3d u = (e.matrix * (m - e.centre)).normalized();
    scatter += u * u.transpose() / static_cast<double>(readings.size());
  }
  return Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(scatter).eigenvalues()[0];
}

MagnetometerCalibration from_ellipsoid(const Ellipsoid& e, double field_uT) {
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

}  // namespace

Result<MagnetometerCalibration> calibrate_magnetometer(
    std::span<const Eigen::Vector3d> readings, const MagnetometerCalibrationOptions& options) {
  const auto kept = distinct(readings, options.least_change);
  const auto too_little = [](const std::string& what) {
    return Error{ErrorCode::degenerate,
                 what + "; rotate the sensor slowly through all orientations, away from iron"};
  };
  if (kept.size() < options.least_readings)
    return too_little("the magnetometer was hardly rotated: " + std::to_string(kept.size()) +
                      " different readings, " + std::to_string(options.least_readings) +
                      " are needed");
  const auto e = fit_ellipsoid(kept);
  if (!e) return too_little("the readings do not determine an ellipsoid");
  auto c = from_ellipsoid(*e, options.field_uT);
  c.used = kept.size();
  c.raw_residual_uT = strength_deviation(kept);
  c.spread = spread_of_directions(kept, *e);
  if (c.spread < options.least_spread)
    return too_little("the field was measured in too few directions: spread " +
                      std::to_string(c.spread) + ", at least " +
                      std::to_string(options.least_spread) + " is needed");
  const double radius = 1.0 / std::cbrt(e->matrix.determinant());
  if (c.offset_sigma_uT.maxCoeff() > options.largest_offset_sigma * radius)
    return too_little("the standard deviation of the offset is " +
                      std::to_string(c.offset_sigma_uT.maxCoeff()) + " uT");
  if (!(e->residual < 0.2))
    return Error{ErrorCode::invalid,
                 "the readings do not lie on an ellipsoid: the field was not the same everywhere"};
  return c;
}

}  // namespace wayfare
