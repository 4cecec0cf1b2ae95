#include <wayfare/io/nav_text.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string_view>

#include <wayfare/core/detail/bytes.hpp>

#include "io/text/lines.hpp"

namespace wayfare::io {
namespace {

constexpr std::size_t kHeader = 76;
constexpr std::size_t kRecord = 8;
constexpr std::int64_t kGpsEpochUnix_s = 315964800;

template <class T>
T little_endian(std::string_view bytes, std::size_t at) {
  return decode::load_le<T>(reinterpret_cast<const std::uint8_t*>(bytes.data()) + at);
}

}  // namespace

Result<TimeTagFile> parse_time_tags(std::string_view bytes, const std::string& source) {
  if (!bytes.starts_with("TIMETAG RTKLIB") || bytes.size() < kHeader)
    return Error{ErrorCode::parse, "does not begin as RTKLIB's time tags do", source};
  const auto start_s = static_cast<std::int64_t>(little_endian<std::uint32_t>(bytes, 64));
  const auto fraction_s = little_endian<double>(bytes, 68);
  if (!(fraction_s >= 0.0 && fraction_s < 1.0))
    return Error{ErrorCode::parse, "the start is not a time", source, 0, 68};
  const LogTime start = LogTime::from_nanoseconds((start_s - kGpsEpochUnix_s) * 1'000'000'000) +
                        from_seconds(fraction_s);
  TimeTagFile file;
  for (std::size_t at = kHeader; at + kRecord <= bytes.size(); at += kRecord) {
    const auto tick_ms = little_endian<std::uint32_t>(bytes, at);
    const TimeTag tag{little_endian<std::uint32_t>(bytes, at + 4),
                      start + std::chrono::milliseconds(tick_ms)};
    if (!file.tags.empty() &&
        (tag.time < file.tags.back().time || tag.bytes < file.tags.back().bytes)) {
      file.problems.add(Error{ErrorCode::parse, "a time tag out of order", source, 0, at});
      continue;
    }
    file.tags.push_back(tag);
  }
  if (file.tags.empty()) return Error{ErrorCode::parse, "contains no time tag", source};
  return file;
}

Result<TimeTagFile> read_time_tags(const std::string& path) {
  return read_and_parse(path, {}, parse_time_tags);
}

Result<ClockFit<LogClock>> fit_time_tags(const ImuFile& file, const TimeTagFile& tags) {
  // With CR LF, the position of the last tag exceeds the file's size by one byte per line.
  std::uint64_t last_line = 0;
  if (!file.ends.empty()) last_line = file.ends.back().line;
  const std::uint64_t size = file.ends.empty() ? 0 : file.ends.back().byte;
  const bool carriage_returns =
      !tags.tags.empty() && tags.tags.back().bytes >= size + last_line - last_line / 10;
  std::vector<ClockPair<LogClock>> pairs;
  for (std::size_t i = 0; i < file.samples.size(); ++i) {
    const std::uint64_t end = file.ends[i].byte + (carriage_returns ? file.ends[i].line : 0);
    const auto tag =
        std::lower_bound(tags.tags.begin(), tags.tags.end(), end,
                         [](const TimeTag& t, std::uint64_t b) { return t.bytes < b; });
    if (tag == tags.tags.end()) break;
    pairs.push_back({file.samples[i].time, tag->time});
  }
  return fit_clock<LogClock>(pairs);
}

}  // namespace wayfare::io
