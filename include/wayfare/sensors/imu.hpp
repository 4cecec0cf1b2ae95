#pragma once

#include <limits>
#include <vector>

#include <Eigen/Core>

#include <wayfare/core/time.hpp>

namespace wayfare {

/// One reading of an inertial unit in its own axes. Specific force: what accelerometers measure, +g
/// upward at rest.
struct ImuSample {
  LogTime time;
  Eigen::Vector3d angular_rate_radps = Eigen::Vector3d::Zero();
  Eigen::Vector3d specific_force_mps2 = Eigen::Vector3d::Zero();
};

/// One instant of a nine-axis unit (magnetic, angular rate, gravity) in its own axes. A missing
/// measurement is NaN.
struct MargSample {
  static constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

  LogTime time;
  Eigen::Vector3d angular_rate_radps = Eigen::Vector3d::Constant(kNone);
  /// What accelerometers measure: +g upward at rest.
  Eigen::Vector3d specific_force_mps2 = Eigen::Vector3d::Constant(kNone);
  Eigen::Vector3d magnetic_field_uT = Eigen::Vector3d::Constant(kNone);
};

using MargRecording = std::vector<MargSample>;

}  // namespace wayfare
