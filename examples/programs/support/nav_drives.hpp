#pragma once

// Drives with a known truth to take satellites away from.

#include <cstdint>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include <wayfare/core/result.hpp>
#include <wayfare/nav/gnss_ins.hpp>
#include <wayfare/sensors/nav_state.hpp>

#include "nav_config.hpp"
#include "nav_recording.hpp"

namespace wayfare::examples {

struct RangeSimulation {
  std::size_t satellites = 8;
  double range_sigma_m = 2.0;
  double rate_sigma_mps = 0.1;
  double period_s = 1.0;
  std::uint64_t seed = 1;
};

/// A recording whose ranges are simulated and whose truth is known at any time.
struct KnownDrive {
  std::string name;
  GnssInsRecording recording;
  GnssInsOptions options;
  std::function<NavState(LogTime)> antenna_truth;  ///< may be called from several threads
  bool attitude_known = false;
  std::vector<std::string> remarks;
};

/// A real unit's readings; ranges simulated along the reference, which gives the antenna's place.
[[nodiscard]] Result<KnownDrive> recorded_drive(const NavFiles& files, const NavConfig& config,
                                                const RangeSimulation& ranges);

/// Everything simulated: the drive of 310 s and 4.5 km, a unit that errs as options.imu says.
[[nodiscard]] KnownDrive simulated_drive(const RangeSimulation& ranges);

}  // namespace wayfare::examples
