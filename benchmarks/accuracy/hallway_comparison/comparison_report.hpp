#pragma once

// What the drives show: tables, the first drive's ways, and the scores about one match as pictures.

#include <cstdint>
#include <string>
#include <vector>

#include <wayfare/eval/table.hpp>
#include <wayfare/io/image.hpp>

#include "drives.hpp"

namespace wayfare::examples {

/// Mean and spread over the drives, a row a sensor.
[[nodiscard]] eval::Table error_table(const std::vector<SeedRuns>& all);
/// A row a drive; the first one's seed is `first`.
[[nodiscard]] eval::Table seed_table(const std::vector<SeedRuns>& all, std::uint64_t first);

/// How far the scores about one match spread, a line a sensor.
[[nodiscard]] std::string spread_text(const SeedRuns& runs);

struct ReportOptions {
  std::string out;  ///< folder
  std::uint64_t first_seed = 1;
  io::WriteOptions write = {};
};

/// The files write_comparison writes.
[[nodiscard]] std::vector<std::string> comparison_files();
[[nodiscard]] Result<void> write_comparison(const std::vector<SeedRuns>& all,
                                            const ReportOptions& o);

}  // namespace wayfare::examples
