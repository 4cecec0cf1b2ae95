#pragma once

// MCAP recordings in, whole or damaged: of a file that was cut off, or is still being written,
// everything up to the last complete chunk is read, and the rest is said.

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include <wayfare/core/result.hpp>
#include <wayfare/io/mcap.hpp>
#include <wayfare/io/text_file.hpp>

namespace wayfare::io {

struct McapReadOptions {
  /// Chunks and other records larger than this are not read; memory is bounded by it.
  std::size_t max_record_bytes = std::size_t{1} << 28;
  std::size_t max_problems = 100;  ///< kept in full; all are counted
};

enum class McapOrder {
  file,      ///< as written: every record from the front of the file on
  log_time,  ///< by the index of chunks; of equal times the one written first comes first
};

struct McapQuery {
  McapOrder order = McapOrder::file;
  std::set<std::string> topics = {};  ///< empty: all
  LogTime from = LogTime::from_nanoseconds(0);
  LogTime until = LogTime::from_nanoseconds(INT64_MAX);  ///< both ends are included
};

/// What is in a file, from its summary; where that is missing or damaged, from the data.
struct McapContents {
  std::string profile, library;
  std::vector<McapSchema> schemas;    ///< in order of their identifiers
  std::vector<McapChannel> channels;  ///< in order of their identifiers
  McapStatistics statistics;
  std::map<std::string, McapMetadata> metadata;  ///< by name; the last of a name stands
  std::uint64_t bytes = 0;                       ///< of the file when it was opened
  bool indexed = false;                          ///< the file's own summary was used
  Problems problems;                             ///< with the byte where each was met
};

/// A recording opened for reading.
class McapReader {
 public:
  /// Errors: cannot be read; does not begin as an MCAP file does. Anything else that is wrong is a
  /// problem in `contents`.
  [[nodiscard]] static Result<McapReader> open(const std::string& path,
                                               const McapReadOptions& options = {});
  /// The same of bytes in memory; `source` names them in messages.
  [[nodiscard]] static Result<McapReader> parse(std::string bytes, const std::string& source,
                                                const McapReadOptions& options = {});
  McapReader(McapReader&&) noexcept;
  McapReader& operator=(McapReader&&) noexcept;
  ~McapReader();

  [[nodiscard]] const McapContents& contents() const;

  /// Calls `sink` with the messages asked for until it returns false. What was met on the way:
  /// chunks whose checksum is wrong are left out, as are messages of channels never described.
  /// Chunks compressed by LZ4 or Zstandard are read where wayfare was built with their libraries;
  /// others are left out and their compression is named.
  Problems read(const McapQuery& query, const std::function<bool(const McapMessage&)>& sink) const;

 private:
  struct Impl;
  explicit McapReader(std::unique_ptr<Impl> impl);
  [[nodiscard]] static Result<McapReader> from(std::unique_ptr<Impl> impl);

  std::unique_ptr<Impl> impl_;
};

}  // namespace wayfare::io
