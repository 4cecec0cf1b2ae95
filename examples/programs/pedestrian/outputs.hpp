#pragma once

#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include <wayfare/core/angle.hpp>
#include <wayfare/core/result.hpp>
#include <wayfare/sensors/recording.hpp>

#include "support/program_files.hpp"
#include "support/truth.hpp"

namespace wayfare::examples {

/// State of the walker after a step, or at a reading of a unit on the foot.
struct WalkRow {
  LogTime time;
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  Angle heading;
  Eigen::Vector3d sigma_m = Eigen::Vector3d::Zero();
  double step_m = 0.0;      ///< length of the step, or of the stride that ends here
  double interval_s = 0.0;  ///< of the step
  double still = 0.0;       ///< stance statistic of the foot
  bool event = false;       ///< a step, or an accepted stance
};

struct WalkRun {
  std::vector<WalkRow> rows;
  /// Norm of the specific force, m/s².
  std::vector<std::pair<LogTime, double>> force;
  Facts facts;
  double walked_m = 0.0;
  std::size_t events = 0;
  bool foot = false;
};

/// Writes track.csv, trajectory.tum and report.html. The truth may be unknown.
[[nodiscard]] Result<void> write_walk_outputs(const OutputArguments& to, const std::string& title,
                                              const WalkRun& run, const Truth& truth);
/// Steps, length, end, use of the readings and, with truth, errors.
[[nodiscard]] std::string walk_text(const WalkRun& run, const Truth& truth);

}  // namespace wayfare::examples
