#pragma once

// Files, table and pictures of several methods on one log.

#include <string>
#include <utility>
#include <vector>

#include <wayfare/core/result.hpp>
#include <wayfare/sensors/trajectory.hpp>

#include "support/program_files.hpp"
#include "support/truth.hpp"

namespace wayfare::examples {

/// A method's result.
struct MethodRun {
  std::string name;   ///< of its file
  std::string title;  ///< in tables and pictures
  Trajectory trajectory;
};

struct MethodOutputs {
  std::string title;  ///< of the report
  std::vector<MethodRun> runs;
  std::vector<std::pair<std::string, std::string>> left_out;  ///< methods, and the reasons
  const Truth& truth;
  Facts facts = {};
  std::string doubt = {};  ///< why the log is in doubt; empty: it is not
};

/// Their paths and, with truth, errors; the methods that were left out.
[[nodiscard]] TitledTables tables_of(const MethodOutputs& outputs);

/// The names of all files that methods of these names have.
[[nodiscard]] std::vector<std::string> files_of(const std::vector<std::string>& methods);

/// Writes a trajectory of each method (NAME.tum), paths.svg and report.html.
[[nodiscard]] Result<void> write_methods(const OutputArguments& to, const MethodOutputs& outputs);

}  // namespace wayfare::examples
