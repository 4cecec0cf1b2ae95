#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include <wayfare/core/result.hpp>
#include <wayfare/eval/trajectory_error.hpp>
#include <wayfare/sensors/recording.hpp>
#include <wayfare/sim/worlds.hpp>

namespace wayfare::examples {

/// A drive, with odometry, gyro, wheels, scans and truth.
struct Drive {
  Recording recording;
  const sim::World* world;
};

struct System {
  std::string name;
  eval::Alignment alignment;  ///< of the estimate with the truth
  std::function<Result<Trajectory>(const Drive&, std::uint64_t seed)> run;
};

/// The systems that process scans, in the order of the table.
[[nodiscard]] std::vector<System> scan_systems();

}  // namespace wayfare::examples
