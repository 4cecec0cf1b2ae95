#include "program_files.hpp"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <system_error>

namespace wayfare::examples {

namespace fs = std::filesystem;

std::string OutputArguments::path(const std::string& name) const {
  return (fs::path(out) / name).string();
}

Result<void> OutputArguments::prepare(const std::vector<std::string>& names) const {
  return prepare_files(out, names, write());
}

void add_out(CommandLine& app, OutputArguments& arguments, const std::string& text) {
  app.add_option("--out", arguments.out, text).required();
}

void add_force_and_quiet(CommandLine& app, OutputArguments& arguments) {
  app.add_flag("--force", arguments.force, "replace existing files");
  app.add_flag("--quiet", arguments.quiet, "print no progress and no results");
}

Result<void> prepare_files(const std::string& folder, const std::vector<std::string>& names,
                           const io::WriteOptions& options) {
  std::error_code code;
  fs::create_directories(folder, code);
  if (code) return Error{ErrorCode::io, "cannot be created: " + code.message(), folder};
  for (const std::string& name : names)
    if (auto ok = refuse_existing({(fs::path(folder) / name).string()}, options); !ok) return ok;
  return {};
}

Result<void> refuse_existing(std::initializer_list<std::string> paths,
                             const io::WriteOptions& options) {
  std::error_code code;
  for (const std::string& path : paths)
    if (options.existing == io::Existing::refuse && !path.empty() && fs::exists(path, code))
      return Error{ErrorCode::io, "already exists; --force replaces it", path};
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
