#pragma once

// Findings of check_drive for the terminal, the report and the exit code.

#include <string>
#include <vector>

#include <wayfare/core/result.hpp>
#include <wayfare/nav/check_drive.hpp>

#include "command_line.hpp"
#include "nav_config.hpp"
#include "program_files.hpp"

namespace wayfare::examples {

/// Whether a result with this finding is in doubt; else it only explains.
[[nodiscard]] bool doubtful(const DriveFinding& finding);

/// The first doubtful finding with its option, and the number of others; empty if there is none.
[[nodiscard]] Doubt doubt_of(const std::vector<DriveFinding>& findings);

/// "text: set option"
[[nodiscard]] std::string line_of(const DriveFinding& finding);

/// `config` with what was found.
[[nodiscard]] NavConfig found_config(NavConfig config, const DriveEstimate& estimate);

/// Compares the recording with its description, refines what was found, prints it and writes
/// found.json, report.html and the numbers of --json.
[[nodiscard]] Result<Doubt> check_nav_recording(const OutputArguments& out,
                                                const std::string& config_path,
                                                const NavConfig& config,
                                                const io::NavRecording& recording);

}  // namespace wayfare::examples
