#pragma once

// Drives as folders: imu.txt, ranges.txt, truth.txt as simulate_drive and cut_drive write them, and
// optionally config.json with mounting and lever arm.

#include <memory>
#include <string>
#include <vector>

#include <wayfare/nav/outage.hpp>
#include <wayfare/tune/ins_fitness.hpp>

#include "support/nav_config.hpp"

namespace wayfare::examples {

struct LoadedDrive {
  std::string name;
  TuningDrive tuning;
  NavTrajectory truth;  ///< of the unit
  NavConfig config;
};

/// The start is the first true state with errors drawn, by `seed`, from the filter's initial
/// standard deviations.
[[nodiscard]] Result<LoadedDrive> load_drive(const std::string& folder, std::uint64_t seed);

/// Root mean square errors of the whole navigation system, including constraints and standstill;
/// NaN where the run failed.
struct SystemErrors {
  Eigen::Vector3d position_ned_m, velocity_ned_mps;
  Eigen::Vector3d attitude_deg;  ///< roll, pitch, yaw; NaN if unknown
  [[nodiscard]] double position_m() const { return position_ned_m.norm(); }
};
[[nodiscard]] SystemErrors system_errors(const LoadedDrive& drive, const GnssInsOptions& options);

/// Ten outages for each length and number of satellites left.
[[nodiscard]] Result<OutageReport> outages(const LoadedDrive& drive, const GnssInsOptions& options,
                                           int threads);

}  // namespace wayfare::examples
