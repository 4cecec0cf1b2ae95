#pragma once

// RTKLIB's time tags (FILE.tag): when each part of a logged stream had arrived at the computer, so
// that a stream without times of its own, or with a device's counter, comes to GPS time.

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

/// At `time`, GPS time by the computer's clock, this many bytes of the stream had come.
struct TimeTag {
  std::uint64_t bytes = 0;
  LogTime time;
};

/// 64 bytes that begin with "TIMETAG RTKLIB", the last four of them the computer's tick; the start
/// as seconds since 1970 (uint32) and their fraction (double), GPS time; then records of the
/// milliseconds since the start and the bytes of the stream by then (uint32 both). Little endian.
struct TimeTagFile {
  std::vector<TimeTag> tags;  ///< neither times nor bytes ever fall
  Problems problems;          ///< records out of order, skipped
};

/// Errors: the file cannot be read, is no time tag, or holds none.
[[nodiscard]] Result<TimeTagFile> read_time_tags(const std::string& path);
[[nodiscard]] Result<TimeTagFile> parse_time_tags(std::string_view bytes,
                                                  const std::string& source);

/// The line from the times of `file`, its device's own counter, to GPS time. Each sample is set
/// beside the tag by which it had come. Streams logged with CR LF and stored with LF alone are
/// recognised by the bytes that the last tag counts and the file does not have.
[[nodiscard]] Result<ClockFit<LogClock>> fit_time_tags(const ImuFile& file,
                                                       const TimeTagFile& tags);

}  // namespace wayfare::io
