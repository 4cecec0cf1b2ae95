#pragma once

// The records of an MCAP file's data section, their messages, and the index of them.

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <wayfare/io/mcap.hpp>

#include "io/recording/mcap_records.hpp"

namespace wayfare::io::mcap {

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

  void fault(std::uint64_t at, std::string message) {
    problems_.add(fault_at(at, std::move(message), name_));
  }

  Description& known_;
  const std::string& name_;
  const McapReadOptions& options_;
  Problems& problems_;
  std::shared_ptr<const std::string> unpacked_;
  std::size_t undescribed_ = 0;
};

// The contents of a recording and the positions of its messages: from its summary, or from all its
// data where that is missing or inconsistent.

/// A chunk, or a message outside of chunks.
struct IndexEntry {
  std::uint64_t at = 0;
  LogTime first, last;
  std::uint64_t until = 0;  ///< end of the chunk and of the message indexes behind it; by a summary
};

struct Index {
  McapContents contents;
  Description known;
  std::vector<IndexEntry> entries;  ///< in order of their first time
};

/// The content of the record of type `opcode` at `at`, if there is one. May use `buffer`.
[[nodiscard]] std::optional<std::string_view> content_at(const Source& source, std::uint64_t at,
                                                         Opcode opcode,
                                                         const McapReadOptions& options,
                                                         std::string& buffer);

/// Faults are reported in the contents' problems.
[[nodiscard]] Index make_index(const Source& source, const std::string& name,
                               const McapReadOptions& options);

}  // namespace wayfare::io::mcap
