#pragma once

// A simulated drive in the corridors, and localisation with each sensor.

#include <array>
#include <cstddef>
#include <cstdint>

#include "errors.hpp"
#include "localise_by_matching.hpp"

namespace wayfare::examples {

constexpr std::array<Sensor, 3> kSensors{Sensor::odometry, Sensor::lidar, Sensor::radar};
constexpr std::array<const char*, 3> kNames{"wheel odometry", "LiDAR", "radar"};

struct DriveOptions {
  std::size_t frames = 20;  ///< radar frames combined into one scan
  double window_m = 0.3;    ///< half the width of the search window
};

/// The drive of one seed, by each of `kSensors`.
struct SeedRuns {
  Trajectory truth;
  std::array<MatchingRun, 3> runs = {};
  std::array<Errors, 3> errors;
};

[[nodiscard]] Result<SeedRuns> run_seed(std::uint64_t seed, const DriveOptions& o);

}  // namespace wayfare::examples
