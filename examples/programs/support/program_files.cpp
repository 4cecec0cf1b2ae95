#include "program_files.hpp"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <system_error>

namespace wayfare::examples {

namespace fs = std::filesystem;

std::string OutputArguments::path(const std::string& name) const {
  return (fs::path(out) / name).string();
}

Result<void> OutputArguments::prepare(const std::vector<std::string>& names) const {
  if (!out.empty())
    if (auto ready = prepare_files(out, names, write()); !ready) return ready;
  return prepare_json();
}

Result<void> OutputArguments::prepare_json() const {
  return json == "-" ? Result<void>{} : check_writable({json}, write());
}

Result<void> OutputArguments::write_report(const io::Report& report) const {
  if (!out.empty())
    if (auto done = report.write(path("report.html"), write()); !done) return done;
  return write_json(report);
}

Result<void> OutputArguments::write_json(const io::Report& numbers) const {
  if (json.empty()) return {};
  if (json != "-") return io::write_file(json, numbers.json(), write());
  const std::string text = numbers.json();
  if (std::fwrite(text.data(), 1, text.size(), stdout) == text.size() && std::fflush(stdout) == 0)
    return {};
  return Error{ErrorCode::io, "cannot be written", "standard output"};
}

void add_out(CommandLine& app, OutputArguments& arguments, const std::string& text) {
  app.add_option("--out", arguments.out, text).shown_as("DIR").required();
}

void add_json(CommandLine& app, OutputArguments& arguments) {
  app.add_word("--json",
               "file for the report's facts, tables and curves as JSON; - for standard output, "
               "with nothing else printed there",
               [&arguments](const std::string& path) {
                 arguments.json = path;
                 if (path == "-") arguments.quiet = true;
               })
      .shown_as("FILE");
}

void add_force_and_quiet(CommandLine& app, OutputArguments& arguments) {
  app.add_flag("--force", arguments.force, "replace existing files");
  app.add_flag("--quiet", arguments.quiet, "print no progress, and no results");
}

Result<void> prepare_files(const std::string& folder, const std::vector<std::string>& names,
                           const io::WriteOptions& options) {
  std::error_code code;
  fs::create_directories(folder, code);
  if (code) return Error{ErrorCode::io, "cannot be created: " + code.message(), folder};
  for (const std::string& name : names)
    if (auto ok = check_writable({(fs::path(folder) / name).string()}, options); !ok) return ok;
  return {};
}

Result<void> check_writable(std::initializer_list<std::string> paths,
                            const io::WriteOptions& options) {
  std::error_code code;
  for (const std::string& path : paths) {
    if (path.empty()) continue;
    if (options.existing == io::Existing::refuse && fs::exists(path, code))
      return Error{ErrorCode::io, "already exists; --force replaces it", path};
    const fs::path folder = fs::absolute(path).parent_path();
    if (::access(folder.c_str(), W_OK | X_OK) != 0)
      return Error{ErrorCode::io, "cannot be written: " + std::generic_category().message(errno),
                   path};
  }
  return {};
}

Result<void> first_error(std::initializer_list<Result<void>> results) {
  for (const Result<void>& result : results)
    if (!result) return result;
  return {};
}

void print_problems(const io::Problems& problems) {
  constexpr std::size_t kShown = 5;
  const std::size_t shown = std::min(problems.first().size(), kShown);
  for (std::size_t i = 0; i < shown; ++i)
    std::fprintf(stderr, "skipped: %s\n", problems.first()[i].to_string().c_str());
  if (problems.count() > kShown)
    std::fprintf(stderr, "skipped: %zu lines in total\n", problems.count());
}

std::string to_text(const Facts& facts, std::size_t width) {
  std::string text;
  for (const auto& [name, value] : facts)
    text +=
        name + std::string(width > name.size() ? width - name.size() : 0, ' ') + ' ' + value + '\n';
  return text;
}

std::string to_text(const TitledTables& tables) {
  std::string text;
  for (const auto& [title, table] : tables) text += "\n" + title + "\n" + table.to_text();
  return text;
}

}  // namespace wayfare::examples
