#pragma once

// Private: time stamps of a CARMEN log that cannot be used as they are, and what replaces them.

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "io/carmen/carmen_lines.hpp"

namespace wayfare::io::carmen {

/// Lines of a longest sequence whose times do not decrease (patience sorting), so that one wrong
/// stamp costs one line and not all after it.
[[nodiscard]] std::vector<bool> largest_ordered_set(const std::vector<LogTime>& times);

/// Lines whose stamps are out of order by no more than half a second, which is the clock's fault
/// and not the line's, and the times between those before and after them; other lines have none.
[[nodiscard]] std::vector<std::optional<LogTime>> times_of_late_lines(
    const std::vector<LogTime>& times);

struct ClockRepair {
  ClockState state = ClockState::usable;
  std::string reason = {};  ///< why, and what was done; empty for a usable clock
};

/// Judges the stamps of `scans`, which are in the order of the file, and sets the times of all
/// lines again where too many of them would be lost: a clock that was set back continues, single
/// stamps out of order are interpolated, the logger's times replace the sensors', and scans without
/// any usable time are numbered in the order of the file.
[[nodiscard]] ClockRepair repair_clock(LogLines& lines, const std::vector<ScanLine>& scans,
                                       Duration default_period);

}  // namespace wayfare::io::carmen
