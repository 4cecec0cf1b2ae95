#pragma once

#include <string>

#include <wayfare/core/result.hpp>
#include <wayfare/logger/logger.hpp>

namespace wayfare::examples {

/// A logger's options from a JSON file, as docs/how-to/logger.md describes it. Configuration files
/// of sensors are relative to its folder. Errors: not JSON, an unknown key, a value out of range.
[[nodiscard]] Result<logger::LoggerOptions> read_logger_config(const std::string& path);

/// An example for the three supported devices.
[[nodiscard]] std::string example_logger_config();

}  // namespace wayfare::examples
