#pragma once

// The computer's clock as a recording has it, and recordings whose stamps are set right by it: a
// logger's stamps do not follow the computer's clock when that is set.

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <wayfare/core/result.hpp>
#include <wayfare/core/time.hpp>
#include <wayfare/io/text_file.hpp>
#include <wayfare/logger/messages.hpp>

namespace wayfare::logger {

/// The clock of the stamps and that of the computer at one moment. A recording has one where each
/// of its files begins, and one for each time that the computer's clock was set.
struct ClockReading {
  LogTime stamp;  ///< by the logger's clock, as all stamps
  LogTime wall;   ///< by the computer's clock, UTC

  /// What is to be added to stamps for the time by the computer's clock.
  [[nodiscard]] Duration offset() const { return wall - stamp; }
  bool operator==(const ClockReading&) const = default;  ///< of both times
};

/// wayfare.ClockReading: `timestamp`, `wall`, and the offset as `offset_s`; on /logger/clock.
[[nodiscard]] MessageSchema clock_reading_schema();
/// The message of a reading.
[[nodiscard]] std::string clock_reading_json(const ClockReading& reading);
/// The inverse. Error: text that is no such message.
[[nodiscard]] Result<ClockReading> parse_clock_reading(std::string_view json);

/// A recording's file and what it says of the clock.
struct RecordedClock {
  std::string path;                    ///< of the file
  std::string run;                     ///< of the logger: equal for all that have one clock
  std::vector<ClockReading> readings;  ///< in order of their stamps
};

/// Error: the file cannot be read, or has no reading.
[[nodiscard]] Result<RecordedClock> read_clock(const std::string& path);

/// Writes a copy of a recording with all its stamps, and the timestamps in its JSON messages, moved
/// by `offset`; returns the faults of the original. Errors: it cannot be read; the copy exists or
/// cannot be written; a stamp would be before 1970.
[[nodiscard]] Result<io::Problems> move_stamps(const std::string& from, const std::string& to,
                                               Duration offset);

}  // namespace wayfare::logger
