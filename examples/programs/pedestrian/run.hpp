#pragma once

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include <wayfare/core/angle.hpp>
#include <wayfare/pedestrian/foot_parameters.hpp>
#include <wayfare/pedestrian/pedestrian.hpp>
#include <wayfare/sensors/marg.hpp>
#include <wayfare/sensors/recording.hpp>

namespace wayfare::examples {

/// Where the walker is: after a step, or at a reading of a unit on the foot.
struct WalkRow {
  LogTime time;
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  Angle heading;
  Eigen::Vector3d sigma_m = Eigen::Vector3d::Zero();
  double step_m = 0.0;      ///< length of the step, or of the stride that ends here
  double interval_s = 0.0;  ///< of the step
  double still = 0.0;       ///< the foot's statistic of standing
  bool event = false;       ///< a step, or a stance that was believed
};

struct WalkRun {
  std::vector<WalkRow> rows;
  /// Strength of the specific force, m/s², in which steps show.
  std::vector<std::pair<LogTime, double>> strength;
  std::vector<std::pair<std::string, std::string>> facts;  ///< what was found, and what went wrong
  double walked_m = 0.0;
  std::size_t events = 0;
  bool foot = false;
};

using Progress = std::function<void(double)>;

[[nodiscard]] WalkRun run_steps(const MargRecording& samples,
                                const PedestrianParameters& parameters, const Progress& progress);
[[nodiscard]] WalkRun run_foot(const MargRecording& samples, const FootParameters& parameters,
                               const Progress& progress);

}  // namespace wayfare::examples
