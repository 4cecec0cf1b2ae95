#pragma once

// The encoding of MCAP records: numbers, and texts and maps preceded by their length.

#include <zlib.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <string_view>

#include <wayfare/io/mcap.hpp>

#include "io/recording/bytes.hpp"

namespace wayfare::io::mcap {

inline constexpr std::string_view kMagic = "\x89MCAP0\r\n";
inline constexpr std::size_t kRecordHead = 9;  ///< opcode and length

enum class Opcode : std::uint8_t {
  header = 1,
  footer = 2,
  schema = 3,
  channel = 4,
  message = 5,
  chunk = 6,
  message_index = 7,
  chunk_index = 8,
  statistics = 11,
  metadata = 12,
  metadata_index = 13,
  summary_offset = 14,
  data_end = 15,
};

[[nodiscard]] inline std::uint32_t crc(std::string_view bytes, std::uint32_t before = 0) {
  uLong sum = before;
  while (!bytes.empty()) {
    const std::size_t n = std::min<std::size_t>(bytes.size(), 1U << 30U);
    sum = crc32(sum, reinterpret_cast<const Bytef*>(bytes.data()), static_cast<uInt>(n));
    bytes.remove_prefix(n);
  }
  return static_cast<std::uint32_t>(sum);
}

/// The content of a map, without its length.
[[nodiscard]] inline std::string pairs_of(const McapMetadata& map) {
  std::string pairs;
  for (const auto& [key, value] : map) pairs += packed(key, value);
  return pairs;
}

/// A record around `content`.
inline void put_record(std::string& out, Opcode opcode, std::string_view content) {
  out += static_cast<char>(opcode);
  put(out, std::uint64_t{content.size()});
  out += content;
}

/// Reads what the functions above write.
class Cursor : public ByteCursor {
 public:
  using ByteCursor::ByteCursor;

  McapMetadata map() {
    McapMetadata pairs;
    Cursor inner(text());
    while (!inner.at_end()) {
      const std::string key(inner.text());
      pairs[key] = std::string(inner.text());
    }
    if (!inner.ok()) fail();
    return pairs;
  }

  /// Reads a time; times after the year 2262 are invalid.
  LogTime time() {
    const auto ns = number<std::uint64_t>();
    constexpr auto kMax = static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max());
    if (ns > kMax) fail();
    return LogTime::from_nanoseconds(static_cast<std::int64_t>(std::min(ns, kMax)));
  }
};

}  // namespace wayfare::io::mcap
