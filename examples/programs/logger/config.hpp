#pragma once

#include <string>

#include <wayfare/core/result.hpp>
#include <wayfare/logger/logger.hpp>

namespace wayfare::examples {

/// A logger's options from a JSON file, as docs/how-to/logger.md describes it. A configuration a sensor
/// names is looked for beside the file. Errors: not JSON, an unknown key, a value out of range.
[[nodiscard]] Result<logger::LoggerOptions> read_logger_config(const std::string& path);

/// A file for the three devices the logger knows.
[[nodiscard]] std::string example_logger_config();

}  // namespace wayfare::examples
