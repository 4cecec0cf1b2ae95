#pragma once

// Results: tables, paths of the first drive, and images of the scores around one match.

#include <cstdint>
#include <string>
#include <vector>

#include "drives.hpp"
#include "support/program_files.hpp"

namespace wayfare::examples {

/// Mean and standard deviation over the drives, one row per sensor.
[[nodiscard]] eval::Table error_table(const std::vector<SeedRuns>& all);
/// One row per drive; `first` is the first seed.
[[nodiscard]] eval::Table seed_table(const std::vector<SeedRuns>& all, std::uint64_t first);

/// Width of the scores around one match, one line per sensor.
[[nodiscard]] std::string spread_text(const SeedRuns& runs);

[[nodiscard]] std::vector<std::string> comparison_files();
[[nodiscard]] Result<void> write_comparison(const OutputArguments& to,
                                            const std::vector<SeedRuns>& all,
                                            std::uint64_t first_seed);

}  // namespace wayfare::examples
