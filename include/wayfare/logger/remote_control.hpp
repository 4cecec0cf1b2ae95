#pragma once

// Control of a logger over a line that may lose or garble bytes: one byte is a command, and what
// was understood is seen in the next status line, which carries a checksum.

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace wayfare::logger {

/// Every command may be given again without harm.
enum class Command : char {
  begin = 'B',      ///< record
  stop = 'S',       ///< record no more
  terminate = 'T',  ///< stop and end the program
  check = 'C',      ///< send a status line now
};

/// Bytes that are no command mean nothing.
[[nodiscard]] std::optional<Command> command_of(std::uint8_t byte);

/// `json`, '*', its CRC-32 in eight hexadecimal digits, end of line.
[[nodiscard]] std::string status_line(std::string_view json);
/// The JSON of such a line (with or without its end), where the checksum is right.
[[nodiscard]] std::optional<std::string_view> status_of_line(std::string_view line);

}  // namespace wayfare::logger
