#pragma once

// A walk by one unit: dead reckoning by steps, or by the foot tracker, and heights by air pressure.

#include <functional>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include <wayfare/core/angle.hpp>
#include <wayfare/io/nav_text.hpp>
#include <wayfare/pedestrian/barometric_height.hpp>
#include <wayfare/pedestrian/parameters.hpp>

#include "support/program_files.hpp"

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
  /// With air pressure: the height by it alone, the fused one and its standard deviation.
  double pressure_height_m = 0.0, height_m = 0.0, height_sigma_m = 0.0;
  double to_north_rad = 0.0;  ///< turn of the path to the mean field so far
};

struct WalkRun {
  std::vector<WalkRow> rows;
  /// Norm of the specific force, m/s².
  std::vector<std::pair<LogTime, double>> force;
  Facts facts;
  std::vector<Step> steps;  ///< that moved the walker
  double walked_m = 0.0;
  std::size_t events = 0;
  bool foot = false, pressure = false;
};

using WalkProgress = std::function<void(double)>;

[[nodiscard]] WalkRun run_steps(const MargRecording& samples,
                                const PedestrianParameters& parameters,
                                const WalkProgress& progress);
[[nodiscard]] WalkRun run_foot(const MargRecording& samples, const FootParameters& parameters,
                               const WalkProgress& progress);

/// Adds heights by the file's air pressure, if it has any. A reading equal to the previous one is a
/// repetition and not used.
void add_heights(WalkRun& run, const io::MargFile& file,
                 const BarometricHeightParameters& parameters);

/// "120 used, 0 missing, …".
[[nodiscard]] std::string readings_text(const SensorReport& report);

}  // namespace wayfare::examples
