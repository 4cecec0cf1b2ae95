#pragma once

#include <string>

#include <wayfare/core/result.hpp>
#include <wayfare/io/text_file.hpp>

#include "run.hpp"

namespace wayfare::examples {

/// Makes `folder` where needed; an error where what is to be written is there and must stay.
[[nodiscard]] Result<void> prepare_walk_folder(const std::string& folder,
                                               const io::WriteOptions& options);
/// Writes track.csv, trajectory.tum and report.html into `folder`; gives the report's path. The
/// truth may be empty.
[[nodiscard]] Result<std::string> write_walk_outputs(const std::string& folder,
                                                     const std::string& title, const WalkRun& run,
                                                     const Trajectory& truth,
                                                     const io::WriteOptions& options);
/// Length, steps and where it ended, what became of the readings, and how far off it was where the
/// truth is known; aligned text.
[[nodiscard]] std::string walk_text(const WalkRun& run, const Trajectory& truth);

}  // namespace wayfare::examples
