#pragma once

#include <string>
#include <vector>

#include <wayfare/core/result.hpp>
#include <wayfare/io/text_file.hpp>

namespace wayfare::examples {

/// Makes `folder` where needed. With `Existing::refuse` it must hold none of the files `names` yet.
/// To be called before the work whose results they take.
[[nodiscard]] Result<void> prepare_files(const std::string& folder,
                                         const std::vector<std::string>& names,
                                         const io::WriteOptions& options);

/// The first few on standard error, and how many there were.
void print_problems(const io::Problems& problems);

}  // namespace wayfare::examples
