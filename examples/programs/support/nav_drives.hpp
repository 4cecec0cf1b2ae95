#pragma once

// Drives with known truth, for simulated outages.

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <wayfare/core/result.hpp>
#include <wayfare/nav/gnss_ins.hpp>
#include <wayfare/sensors/trajectory.hpp>
#include <wayfare/sim/vehicle_trajectory.hpp>

#include "command_line.hpp"
#include "nav_config.hpp"

namespace wayfare::examples {

struct RangeSimulation {
  std::size_t satellites = 8;
  double range_sigma_m = 2.0;
  double rate_sigma_mps = 0.1;
  double period_s = 1.0;
  std::uint64_t seed = 1;
  bool phases = false;  ///< with carrier phases
  /// Wheels, simulated as well; none by default.
  std::optional<sim::WheelSpeedParams> wheels;
};

/// A recording with ranges and the truth at any time.
struct KnownDrive {
  std::string name;
  bool recorded_ranges = false;  ///< else simulated along the truth
  GnssInsRecording recording;
  GnssInsOptions options;
  std::function<NavState(LogTime)> antenna_truth;  ///< may be called from several threads
  bool attitude_known = false;
  std::vector<std::string> remarks;
};

/// --obs and --nav, or --ranges: the recorded ranges of a drive.
void add_recorded_ranges(CommandLine& app, NavFiles& files);

/// Readings of a real unit. The ranges are those of the files, within the time of the reference;
/// without such files simulated along the reference, which is the antenna's position.
[[nodiscard]] Result<KnownDrive> recorded_drive(const NavFiles& files, const NavConfig& config,
                                                const RangeSimulation& ranges);

/// All simulated: the drive of 310 s and 4.5 km, with the unit's noise of options.imu.
[[nodiscard]] KnownDrive simulated_drive(const RangeSimulation& ranges);

}  // namespace wayfare::examples
