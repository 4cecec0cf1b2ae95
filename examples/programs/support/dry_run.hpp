#pragma once

// The first rows of a recording's files as the readers understand them.

#include <string>

#include <wayfare/core/result.hpp>

#include "nav_config.hpp"

namespace wayfare::examples {

/// For each text file of columns, fixes or reference: its columns as chosen, the number of rows and
/// of skipped lines, the first rows and the last with times and units. Errors: those of the
/// readers.
[[nodiscard]] Result<std::string> dry_run(const NavFiles& files, const NavConfig& config);

}  // namespace wayfare::examples
