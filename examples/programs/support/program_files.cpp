#include "program_files.hpp"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <system_error>

namespace wayfare::examples {

namespace fs = std::filesystem;

Result<void> prepare_files(const std::string& folder, const std::vector<std::string>& names,
                           const io::WriteOptions& options) {
  std::error_code code;
  fs::create_directories(folder, code);
  if (code) return Error{ErrorCode::io, "the folder cannot be made: " + code.message(), folder};
  if (options.existing == io::Existing::replace) return {};
  for (const std::string& name : names) {
    const fs::path path = fs::path(folder) / name;
    if (!fs::exists(path, code)) continue;
    return Error{ErrorCode::io, "is there already; --force overwrites it", path.string()};
  }
  return {};
}

void print_problems(const io::Problems& problems) {
  constexpr std::size_t kShown = 5;
  const std::size_t shown = std::min(problems.first().size(), kShown);
  for (std::size_t i = 0; i < shown; ++i)
    std::fprintf(stderr, "skipped: %s\n", problems.first()[i].to_string().c_str());
  if (problems.count() > kShown)
    std::fprintf(stderr, "skipped: %zu lines in all\n", problems.count());
}

}  // namespace wayfare::examples
