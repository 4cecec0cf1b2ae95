#pragma once

// The methods that a log can be followed with, each by its system's own entry point with its
// defaults.

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <wayfare/core/result.hpp>
#include <wayfare/sensors/recording.hpp>

#include "ahrs/recording.hpp"
#include "support/slam_program.hpp"

namespace wayfare::examples {

/// What the methods work on.
struct MethodData {
  Recording recording;
  std::optional<UnitReadings> unit = {};
  UnitOptions mounting = {};  ///< of the unit
  int threads = 1;
  std::uint64_t seed = 1;
};

struct Method {
  std::string name;    ///< of --methods and of its files
  std::string title;   ///< in tables and pictures
  std::string inputs;  ///< for --help
  /// What it needs and the log lacks; empty if nothing.
  std::function<std::string(const MethodData&)> lacks;
  std::function<Result<Trajectory>(const MethodData&, const SlamProgress&)> run;
};

/// In the order of their results.
[[nodiscard]] const std::vector<Method>& methods();

}  // namespace wayfare::examples
