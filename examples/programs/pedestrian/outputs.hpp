#pragma once

#include <string>

#include <wayfare/core/result.hpp>

#include "run.hpp"

namespace wayfare::examples {

[[nodiscard]] std::vector<std::string> walk_output_names();
/// The truth may be empty.
[[nodiscard]] Result<void> write_walk_outputs(const OutputArguments& to, const std::string& title,
                                              const WalkRun& run, const Trajectory& truth);
/// Steps, length, end, use of the readings and, with truth, errors.
[[nodiscard]] std::string walk_text(const WalkRun& run, const Trajectory& truth);

}  // namespace wayfare::examples
