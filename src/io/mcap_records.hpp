#pragma once

// The bytes MCAP's records are made of: little-endian numbers, texts and maps behind their length.

#include <zlib.h>

#include <algorithm>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <string_view>

#include <wayfare/io/mcap.hpp>

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

template <std::unsigned_integral T>
void put(std::string& out, T value) {
  for (std::size_t i = 0; i < sizeof(T); ++i)
    out += static_cast<char>(static_cast<std::uint8_t>(std::uint64_t{value} >> (8 * i)));
}

inline void put_text(std::string& out, std::string_view text) {
  put(out, static_cast<std::uint32_t>(text.size()));
  out += text;
}

inline void put_map(std::string& out, const McapMetadata& map) {
  std::string pairs;
  for (const auto& [key, value] : map) put_text(pairs, key), put_text(pairs, value);
  put_text(out, pairs);
}

/// A record around `content`.
inline void put_record(std::string& out, Opcode opcode, std::string_view content) {
  out += static_cast<char>(opcode);
  put(out, std::uint64_t{content.size()});
  out += content;
}

/// Reads what the functions above write. Past the end everything is zero or empty and `ok` false.
class Cursor {
 public:
  explicit Cursor(std::string_view bytes) : rest_(bytes) {}

  template <std::unsigned_integral T>
  T number() {
    const std::string_view b = bytes(sizeof(T));
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < b.size(); ++i)
      value |= std::uint64_t{static_cast<std::uint8_t>(b[i])} << (8 * i);
    return static_cast<T>(value);
  }

  std::string_view bytes(std::uint64_t n) {
    if (n > rest_.size()) {
      ok_ = false;
      rest_ = {};
      return {};
    }
    const std::string_view taken = rest_.substr(0, static_cast<std::size_t>(n));
    rest_.remove_prefix(taken.size());
    return taken;
  }

  std::string_view text() { return bytes(number<std::uint32_t>()); }

  McapMetadata map() {
    McapMetadata pairs;
    Cursor inner(text());
    while (!inner.at_end()) {
      const std::string key(inner.text());
      pairs[key] = std::string(inner.text());
    }
    ok_ = ok_ && inner.ok();
    return pairs;
  }

  /// A time as the library counts it; one past the year 2262 is no time.
  LogTime time() {
    const auto ns = number<std::uint64_t>();
    constexpr auto kMax = static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max());
    if (ns > kMax) ok_ = false;
    return LogTime::from_nanoseconds(static_cast<std::int64_t>(std::min(ns, kMax)));
  }

  [[nodiscard]] bool ok() const { return ok_; }
  [[nodiscard]] bool at_end() const { return rest_.empty(); }
  [[nodiscard]] std::string_view rest() const { return rest_; }

 private:
  std::string_view rest_;
  bool ok_ = true;
};

}  // namespace wayfare::io::mcap
