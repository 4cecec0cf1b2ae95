#pragma once

// Control of a logger over a line that may lose or corrupt bytes: a command is one byte, and the
// next status line, which has a checksum, shows its effect.

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace wayfare::logger {

/// Every command may be repeated without harm.
enum class Command : char {
  begin = 'B',      ///< start recording
  stop = 'S',       ///< stop recording
  terminate = 'T',  ///< stop and end the program
  check = 'C',      ///< send a status line now
};

/// Nothing for bytes that are no command.
[[nodiscard]] std::optional<Command> command_of(std::uint8_t byte);

/// `json`, '*', its CRC-32 in eight hexadecimal digits, end of line.
[[nodiscard]] std::string status_line(std::string_view json);
/// The JSON of such a line (with or without its end), if the checksum is right.
[[nodiscard]] std::optional<std::string_view> status_of_line(std::string_view line);

}  // namespace wayfare::logger
