#pragma once

#include <string>

#include <wayfare/core/result.hpp>

#include "support/program_files.hpp"
#include "support/truth.hpp"
#include "walk.hpp"

namespace wayfare::examples {

/// Writes track.csv, trajectory.tum and report.html. The truth may be unknown.
[[nodiscard]] Result<void> write_walk_outputs(const OutputArguments& to, const std::string& title,
                                              const WalkRun& run, const Truth& truth);
/// Steps, length, end, use of the readings and, with truth, errors.
[[nodiscard]] std::string walk_text(const WalkRun& run, const Truth& truth);

}  // namespace wayfare::examples
