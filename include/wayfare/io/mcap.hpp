#pragma once

// What an MCAP recording is made of. MCAP is a container for time-stamped messages of any encoding;
// the format is published at mcap.dev (version 0, magic "\x89MCAP0\r\n").

// MCAP recordings in, whole or damaged: of a file that was cut off, or is still being written,
// everything up to the last complete chunk is read, and the rest is said.

// MCAP recordings out: messages gathered in chunks, each with its checksum and the indexes of its
// messages, and a summary at the end. What was flushed can be read whatever happens next; the
// summary only makes reading quicker.

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include <wayfare/core/result.hpp>
#include <wayfare/core/time.hpp>
#include <wayfare/io/byte_sink.hpp>
#include <wayfare/io/text_file.hpp>

namespace wayfare::io {

using McapMetadata = std::map<std::string, std::string>;

/// What the bytes of a message mean; identifiers count from 1, 0 is "no schema".
struct McapSchema {
  std::uint16_t id = 0;
  std::string name = {};      ///< such as foxglove.LaserScan
  std::string encoding = {};  ///< such as jsonschema
  std::string data = {};
};

/// A stream of messages of one kind.
struct McapChannel {
  std::uint16_t id = 0;
  std::uint16_t schema = 0;
  std::string topic = {};
  std::string message_encoding = {};  ///< such as json
  McapMetadata metadata = {};
};

/// One message as a reader delivers it; `channel` and `data` are gone when the callable returns.
struct McapMessage {
  const McapChannel* channel = nullptr;
  std::uint32_t sequence = 0;
  LogTime log_time;      ///< when it was received
  LogTime publish_time;  ///< when it was made or measured
  std::string_view data;
};

/// How much a file holds.
struct McapStatistics {
  std::uint64_t messages = 0;
  std::uint32_t chunks = 0;
  LogTime first, last;  ///< log times of the earliest and the latest message
  std::map<std::uint16_t, std::uint64_t> messages_of;  ///< by channel
};

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

struct McapWriterOptions {
  std::string profile = {};             ///< of the file, as its format names it; none by default
  std::string library = "wayfare";      ///< who wrote it
  std::size_t chunk_bytes = 1U << 20U;  ///< a chunk is written out once it holds this much
};

/// Writes one file. Chunks are not compressed. The first error stands: every later call gives it
/// again, and the file keeps what was flushed before.
class McapWriter {
 public:
  /// Errors: the file is there already (see `write`), or cannot be written.
  [[nodiscard]] static Result<McapWriter> create(const std::string& path,
                                                 const McapWriterOptions& options = {},
                                                 const WriteOptions& write = {});
  [[nodiscard]] static Result<McapWriter> create(std::unique_ptr<ByteSink> sink,
                                                 const McapWriterOptions& options = {});
  McapWriter(McapWriter&&) noexcept;
  McapWriter& operator=(McapWriter&&) noexcept;
  /// Closes the file where that was not done; `close` says whether it went well.
  ~McapWriter();

  /// Identifiers to refer to them by. Error: there are 65535 already, or a text is longer than 4
  /// GB.
  [[nodiscard]] Result<std::uint16_t> add_schema(const std::string& name,
                                                 const std::string& encoding,
                                                 const std::string& data);
  [[nodiscard]] Result<std::uint16_t> add_channel(const std::string& topic,
                                                  const std::string& message_encoding,
                                                  std::uint16_t schema = 0,
                                                  const McapMetadata& metadata = {});

  /// Takes a message. Errors: no such channel, a time before 1970 or what the file's own clock
  /// calls its epoch (neither ends the file), or the disk's.
  [[nodiscard]] Result<void> write(std::uint16_t channel, LogTime log_time, LogTime publish_time,
                                   std::string_view data);
  /// Pairs of texts about the recording as a whole; on the disk at once.
  [[nodiscard]] Result<void> add_metadata(const std::string& name, const McapMetadata& pairs);

  /// Closes the chunk and hands it to the operating system: it outlives this program.
  [[nodiscard]] Result<void> flush();
  /// Flushes, and returns when it outlives a power cut.
  [[nodiscard]] Result<void> sync();
  /// Writes the summary and ends the file. No more can be written.
  [[nodiscard]] Result<void> close();

  [[nodiscard]] const McapStatistics& statistics() const;
  [[nodiscard]] std::uint64_t bytes_written() const;  ///< without what is not flushed

 private:
  struct Impl;
  explicit McapWriter(std::unique_ptr<Impl> impl);

  std::unique_ptr<Impl> impl_;
};

}  // namespace wayfare::io
