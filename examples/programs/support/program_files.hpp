#pragma once

// Where a program writes, and what it prints.

#include <initializer_list>
#include <string>
#include <utility>
#include <vector>

#include <wayfare/core/result.hpp>
#include <wayfare/eval/table.hpp>
#include <wayfare/io/report.hpp>
#include <wayfare/io/text_file.hpp>

#include "command_line.hpp"

namespace wayfare::examples {

struct OutputArguments {
  std::string out;   ///< folder of the results, or the only file
  std::string json;  ///< file of the report's numbers, "-" for standard output; empty: none
  bool force = false;
  bool quiet = false;

  /// Replaces files only with --force.
  [[nodiscard]] io::WriteOptions write() const {
    return {force ? io::Existing::replace : io::Existing::refuse};
  }
  /// Of a file in the folder.
  [[nodiscard]] std::string path(const std::string& name) const;
  /// Creates the folder, if one is named. An error if one of the files `names` in it, or that of
  /// --json, cannot be written, or exists without --force. To be called before the work whose
  /// results they take.
  [[nodiscard]] Result<void> prepare(const std::vector<std::string>& names) const;
  /// Whether write_report() writes anything.
  [[nodiscard]] bool wants_report() const { return !out.empty() || !json.empty(); }
  /// The same for the file of --json alone.
  [[nodiscard]] Result<void> prepare_json() const;
  /// As HTML in report.html of the folder, if one is named, and as JSON for --json.
  [[nodiscard]] Result<void> write_report(const io::Report& report) const;
  /// For --json alone, of a program without a report.
  [[nodiscard]] Result<void> write_json(const io::Report& numbers) const;
};

// What --help says about options of several programs.
inline constexpr const char* kResultsFolder = "folder for the results, created if needed";
inline constexpr const char* kQuietHelp = "print no progress";
inline constexpr const char* kSeedHelp =
    "of the random numbers: the same seed gives the same result";
inline constexpr const char* kThreadsHelp = "worker threads; results do not depend on their number";

/// --out, required: a folder.
void add_out(CommandLine& app, OutputArguments& arguments,
             const std::string& text = kResultsFolder);
/// --force and --quiet.
void add_force_and_quiet(CommandLine& app, OutputArguments& arguments);
/// --json. With standard output as its file the program is quiet.
void add_json(CommandLine& app, OutputArguments& arguments);

/// As OutputArguments::prepare.
[[nodiscard]] Result<void> prepare_files(const std::string& folder,
                                         const std::vector<std::string>& names,
                                         const io::WriteOptions& options);
/// An error for the first of `paths` that exists and is not to be replaced, or whose folder cannot
/// be written; empty ones are not checked.
[[nodiscard]] Result<void> check_writable(std::initializer_list<std::string> paths,
                                          const io::WriteOptions& options);

/// Of several writes, all of which are tried.
[[nodiscard]] Result<void> first_error(std::initializer_list<Result<void>> results);

/// Prints the first few on standard error, and their number.
void print_problems(const io::Problems& problems);

using Facts = std::vector<std::pair<std::string, std::string>>;  ///< ("scans", "4791") …
using TitledTables = std::vector<std::pair<std::string, eval::Table>>;

/// A line for each fact, values aligned behind names of `width` characters.
[[nodiscard]] std::string to_text(const Facts& facts, std::size_t width = 14);
/// Each table below its title.
[[nodiscard]] std::string to_text(const TitledTables& tables);

}  // namespace wayfare::examples
