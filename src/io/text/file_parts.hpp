#pragma once

#include <functional>
#include <string>
#include <string_view>

#include <wayfare/core/result.hpp>
#include <wayfare/io/text_file.hpp>

namespace wayfare::io {

/// Appends to a file; false after an error, when the rest need not be made.
using AppendPart = std::function<bool(std::string_view)>;
/// Makes the content of a file part by part.
using FileParts = std::function<void(const AppendPart&)>;

/// As write_file, for content that is not in memory as a whole.
[[nodiscard]] Result<void> write_file_parts(const std::string& path, const FileParts& produce,
                                            const WriteOptions& options = {});

}  // namespace wayfare::io
