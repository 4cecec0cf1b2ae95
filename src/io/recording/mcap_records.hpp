#pragma once

// The encoding of MCAP records: numbers, and texts and maps preceded by their length; the records
// of a file's data section, and their messages.

#include <zlib.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <optional>
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

struct Record {
  Opcode opcode = Opcode::header;
  std::uint64_t at = 0;  ///< of its opcode in the file
  std::string_view content;

  [[nodiscard]] std::uint64_t bytes() const { return kRecordHead + content.size(); }
};

/// Removes the first record from `rest`, which begins at `at` in the file, if any.
[[nodiscard]] std::optional<Record> take_record(std::string_view& rest, std::uint64_t at);

/// The first bytes of a record.
struct RecordHead {
  std::uint8_t code = 0;
  std::uint64_t length = 0;  ///< of the content that follows
};
/// nullopt where the file ends before it. May use `buffer`.
[[nodiscard]] std::optional<RecordHead> head_at(const Source& source, std::uint64_t at,
                                                std::string& buffer);

/// Iterates over the records and skips damaged parts.
class Walk {
 public:
  Walk(const Source& source, const std::string& name, const McapReadOptions& options,
       Problems& problems)
      : source_(source), name_(name), options_(options), problems_(problems) {}

  /// The records of the data section in order, until `visit` returns false.
  void run(const std::function<bool(const Record&)>& visit);

 private:
  [[nodiscard]] std::optional<Record> record_at(std::uint64_t at);
  /// Position of the next chunk with a correct checksum, else the file's size.
  [[nodiscard]] std::uint64_t next_chunk(std::uint64_t from);
  [[nodiscard]] bool is_chunk(std::uint64_t at, std::string_view head);

  const Source& source_;
  const std::string& name_;
  const McapReadOptions& options_;
  Problems& problems_;
  std::string buffer_, probe_, unpacked_;
  std::uint64_t effort_ = 0;  ///< bytes checked for false chunks
};

/// Schemas and channels of a recording.
struct Description {
  std::map<std::uint16_t, McapSchema> schemas;
  std::map<std::uint16_t, McapChannel> channels;

  /// False where the record is malformed, or gives a known channel another topic.
  bool take(const Record& record);
};

/// Extracts messages from records; schemas and channels are registered in order of appearance.
class Messages {
 public:
  using Sink = std::function<bool(const McapMessage&)>;

  Messages(Description& known, const std::string& name, const McapReadOptions& options,
           Problems& problems)
      : known_(known), name_(name), options_(options), problems_(problems) {}

  /// The bytes to which the messages of the last record refer if that is a compressed chunk; null
  /// if they refer to the record's own bytes.
  [[nodiscard]] const std::shared_ptr<const std::string>& unpacked() const { return unpacked_; }

  /// Number of messages skipped because their channel was not described before.
  [[nodiscard]] std::size_t undescribed() const { return undescribed_; }

  /// False once `sink` returns false.
  bool take(const Record& record, const Sink& sink);

 private:
  /// A record of the file, or of a chunk.
  bool take_any(const Record& record, const Sink& sink);
  bool take_chunk(const Record& record, const Sink& sink);

  /// Returns true: reading continues after the fault.
  bool fault(std::uint64_t at, std::string message, ErrorCode code = ErrorCode::parse) {
    problems_.add(fault_at(at, std::move(message), name_, code));
    return true;
  }

  Description& known_;
  const std::string& name_;
  const McapReadOptions& options_;
  Problems& problems_;
  std::shared_ptr<const std::string> unpacked_;
  std::size_t undescribed_ = 0;
};

}  // namespace wayfare::io::mcap
