#pragma once

#include <string>

#include <wayfare/core/result.hpp>
#include <wayfare/io/tum.hpp>

#include "support/program_files.hpp"
#include "walk.hpp"

namespace wayfare::examples {

/// Writes track.csv, trajectory.tum and report.html. The truth, in order of time, may be empty.
[[nodiscard]] Result<void> write_walk_outputs(const OutputArguments& to, const std::string& title,
                                              const WalkRun& run, const io::Trajectory3& truth);
/// Steps, length, end, use of the readings and, with truth, errors.
[[nodiscard]] std::string walk_text(const WalkRun& run, const io::Trajectory3& truth);

}  // namespace wayfare::examples
