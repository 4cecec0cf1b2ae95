#pragma once

// RTKLIB's time tags (FILE.tag): the arrival times of a logged stream's parts at the computer,
// which convert a stream without times, or with a device's counter, to GPS time.

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include <wayfare/core/result.hpp>
#include <wayfare/core/time.hpp>
#include <wayfare/io/nav_text.hpp>
#include <wayfare/io/text_file.hpp>
#include <wayfare/sync/clock_fit.hpp>

namespace wayfare::io {

/// At `time`, GPS time by the computer's clock, this number of bytes of the stream had arrived.
struct TimeTag {
  std::uint64_t bytes = 0;
  LogTime time;
};

/// 64 bytes that begin with "TIMETAG RTKLIB", the last four of them the computer's tick; the start
/// as seconds since 1970 (uint32) and their fraction (double), GPS time; then records of the
/// milliseconds since the start and the bytes of the stream by then (uint32 both). Little endian.
struct TimeTagFile {
  std::vector<TimeTag> tags;  ///< times and bytes do not decrease
  Problems problems;          ///< records out of order, skipped
};

/// Errors: the file cannot be read, is not a time tag file, or contains no tag.
[[nodiscard]] Result<TimeTagFile> read_time_tags(const std::string& path);
[[nodiscard]] Result<TimeTagFile> parse_time_tags(std::string_view bytes,
                                                  const std::string& source);

/// The linear fit from the times of `file`, its device's own counter, to GPS time. Each sample is
/// paired with the first tag after its arrival. Streams logged with CR LF but stored with LF alone
/// are detected by the byte count of the last tag, which exceeds the file's size.
[[nodiscard]] Result<ClockFit<LogClock>> fit_time_tags(const ImuFile& file,
                                                       const TimeTagFile& tags);

}  // namespace wayfare::io
