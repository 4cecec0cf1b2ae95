#pragma once

#include <functional>
#include <vector>

#include <Eigen/Core>

#include <wayfare/core/so3.hpp>
#include <wayfare/inertial/ahrs.hpp>
#include <wayfare/sensors/imu.hpp>

namespace wayfare::examples {

/// State of the filter after a sample.
struct AhrsRow {
  LogTime time;
  bool ready = false;
  SO3d q_world_body;
  Eigen::Vector3d sigma_rad = Eigen::Vector3d::Zero();  ///< about the axes of the world
  Eigen::Vector3d bias_radps = Eigen::Vector3d::Zero();
  Eigen::Vector3d bias_sigma_radps = Eigen::Vector3d::Zero();
  double delay_s = 0.0;
  bool at_rest = false;
  MargUpdateStatus status;
};

struct AhrsRun {
  std::vector<AhrsRow> rows;
  AhrsReport report;
};

/// `progress` is called with the fraction done.
[[nodiscard]] AhrsRun run_ahrs(const MargRecording& samples, const AhrsParameters& parameters,
                               bool enu, const std::function<void(double)>& progress);

}  // namespace wayfare::examples
