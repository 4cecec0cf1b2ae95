#pragma once

// Drives as folders: imu.txt, ranges.txt, truth.txt as simulate_drive and cut_drive write them, and
// config.json where mounting or lever arm are not the default's.

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
  bool has_config = false;
};

/// The start is the truth's first state moved by errors of the deviations that the filter is told,
/// drawn by `seed`.
[[nodiscard]] Result<LoadedDrive> load_drive(const std::string& folder, std::uint64_t seed);

/// What the whole navigation system, constraints and standstill and all, misses the truth by.
struct SystemErrors {
  bool diverged = false;
  Eigen::Vector3d position_ned_m, velocity_ned_mps;
  Eigen::Vector3d attitude_deg;  ///< roll, pitch, yaw; NaN where not known
  [[nodiscard]] double position_m() const { return position_ned_m.norm(); }
};
[[nodiscard]] SystemErrors system_errors(const LoadedDrive& drive, const GnssInsOptions& options);

/// Ten outages of each length and number of satellites left.
[[nodiscard]] Result<OutageReport> outages(const LoadedDrive& drive, const GnssInsOptions& options,
                                           int threads);

}  // namespace wayfare::examples
