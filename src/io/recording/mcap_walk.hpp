#pragma once

// Iterates over the records of an MCAP file's data section and skips damaged parts.

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include <wayfare/io/mcap.hpp>

#include "io/recording/byte_source.hpp"
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

/// A chunk's header and its records.
struct ChunkHead {
  LogTime first, last;
  std::uint64_t size = 0;
  std::uint32_t crc = 0;
  std::string_view compression, records;
  bool whole = false;  ///< the content's length matches the header
};

[[nodiscard]] ChunkHead read_chunk_head(std::string_view content);

/// A chunk's records, decompressed to `buffer` where necessary. Errors, without a position:
/// damaged; larger than `max_bytes`.
[[nodiscard]] Result<std::string_view> records_of(const ChunkHead& chunk, std::size_t max_bytes,
                                                  std::string& buffer);

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

}  // namespace wayfare::io::mcap
