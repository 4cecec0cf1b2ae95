#pragma once

#include <functional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include <wayfare/core/result.hpp>
#include <wayfare/core/se3.hpp>
#include <wayfare/inertial/ahrs.hpp>
#include <wayfare/io/nav_text.hpp>
#include <wayfare/sensors/measurements.hpp>

#include "support/program_files.hpp"

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

struct AhrsOutputs {
  std::string title;
  const io::MargFile& file;
  const AhrsRun& run;
  double took_s = 0.0;
};

/// Numbers of readings used, missing and refused, by sensor.
[[nodiscard]] std::string status_text(const AhrsReport& report);
/// Root mean square errors over the moving samples; empty without a reference.
[[nodiscard]] std::string error_text(const AhrsOutputs& outputs);

[[nodiscard]] std::vector<std::string> ahrs_output_names();
[[nodiscard]] Result<void> write_ahrs_outputs(const OutputArguments& to,
                                              const AhrsOutputs& outputs);

}  // namespace wayfare::examples
