#pragma once

// Reading and writing MCAP recordings. MCAP is a container for time-stamped messages of any
// encoding; the format is published at mcap.dev (version 0, magic "\x89MCAP0\r\n"). A file that is
// truncated, or still being written, is read up to its last complete chunk, and the rest is
// reported. The writer groups messages in chunks with checksums and message indexes and appends a
// summary, which only makes reading faster: flushed chunks are readable without it.

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <wayfare/core/detail/owned.hpp>
#include <wayfare/core/result.hpp>
#include <wayfare/core/time.hpp>
#include <wayfare/io/text_file.hpp>

namespace wayfare::io {

using McapMetadata = std::map<std::string, std::string>;  ///< key and value

/// The encoding of a message's bytes; identifiers count from 1, 0 is "no schema".
struct McapSchema {
  std::uint16_t id = 0;       ///< from 1
  std::string name = {};      ///< such as foxglove.LaserScan
  std::string encoding = {};  ///< such as jsonschema
  std::string data = {};      ///< its definition in that encoding
};

/// A stream of messages of one type.
struct McapChannel {
  std::uint16_t id = 0;               ///< from 0
  std::uint16_t schema = 0;           ///< of its messages; 0: none
  std::string topic = {};             ///< such as /scan
  std::string message_encoding = {};  ///< such as json
  McapMetadata metadata = {};         ///< of the channel
};

/// One message; `channel` and `data` are valid until the reader's callable returns.
struct McapMessage {
  const McapChannel* channel = nullptr;  ///< its topic and encoding
  std::uint32_t sequence = 0;            ///< number given by the writer
  LogTime log_time;                      ///< when it was received
  LogTime publish_time;                  ///< when it was made or measured
  std::string_view data;                 ///< the message's bytes
};

/// Message counts and time range of a file.
struct McapStatistics {
  std::uint64_t messages = 0;                          ///< in all channels
  std::uint32_t chunks = 0;                            ///< groups of messages
  LogTime first,                                       ///< log time of the earliest message
      last;                                            ///< of the latest one
  std::map<std::uint16_t, std::uint64_t> messages_of;  ///< by channel
};

/// Limits of a McapReader.
struct McapReadOptions {
  /// Larger chunks and records are not read; this bounds the memory.
  std::size_t max_record_bytes = std::size_t{1} << 28;
  std::size_t max_problems = 100;  ///< kept in full; all are counted
};

/// Order of delivery.
enum class McapOrder {
  file,      ///< the order of the file
  log_time,  ///< sorted by time, for equal times by order of writing; uses the chunk index
};

/// Which messages to read, and in which order.
struct McapQuery {
  McapOrder order = McapOrder::file;                     ///< of delivery
  std::set<std::string> topics = {};                     ///< empty: all
  LogTime from = LogTime::from_nanoseconds(0);           ///< earliest log time
  LogTime until = LogTime::from_nanoseconds(INT64_MAX);  ///< both ends are included
};

/// The contents of a file from its summary, or from the data where that is missing or damaged.
struct McapContents {
  std::string profile,                           ///< MCAP profile
      library;                                   ///< name of the library that wrote it
  std::vector<McapSchema> schemas;               ///< in order of their identifiers
  std::vector<McapChannel> channels;             ///< in order of their identifiers
  McapStatistics statistics;                     ///< counts and time range
  std::map<std::string, McapMetadata> metadata;  ///< by name; the last of each name is kept
  std::uint64_t bytes = 0;                       ///< of the file when it was opened
  bool indexed = false;                          ///< the file's own summary was used
  Problems problems;                             ///< each with its byte offset
};

/// A recording opened for reading; copies share it.
class McapReader {
 public:
  /// Errors: cannot be read; does not begin as an MCAP file does. Everything else is reported as a
  /// problem in `contents`.
  [[nodiscard]] static Result<McapReader> open(const std::string& path,
                                               const McapReadOptions& options = {});
  /// The same for bytes in memory; `source` names them in messages.
  [[nodiscard]] static Result<McapReader> parse(std::string bytes, const std::string& source,
                                                const McapReadOptions& options = {});

  /// As found when the file was opened.
  [[nodiscard]] const McapContents& contents() const;

  /// Calls `sink` with the messages of `query` until it returns false. Returns the problems: chunks
  /// with a wrong checksum and messages of undescribed channels are skipped. Chunks compressed by
  /// LZ4 or Zstandard are read if wayfare was built with their libraries; others are skipped and
  /// their compression is reported.
  Problems read(const McapQuery& query, const std::function<bool(const McapMessage&)>& sink) const;

 private:
  struct Impl;
  explicit McapReader(std::shared_ptr<const Impl> impl) : impl_(std::move(impl)) {}
  [[nodiscard]] static Result<McapReader> from(std::shared_ptr<Impl> impl);

  std::shared_ptr<const Impl> impl_;
};

/// Head and chunks of a file.
struct McapWriterOptions {
  std::string profile = {};             ///< MCAP profile of the file; none by default
  std::string library = "wayfare";      ///< name of the writing library
  std::size_t chunk_bytes = 1U << 20U;  ///< size at which a chunk is written
};

/// Writes one file. Chunks are not compressed. After an error every later call returns the same
/// error, and the file keeps what was flushed before. The destructor closes the file if necessary;
/// call `close` to obtain its errors.
class McapWriter {
 public:
  /// Errors: the file exists (see `write`), or cannot be written.
  [[nodiscard]] static Result<McapWriter> create(const std::string& path,
                                                 const McapWriterOptions& options = {},
                                                 const WriteOptions& write = {});
  /// To any destination; writes the head at once.
  [[nodiscard]] static Result<McapWriter> create(std::unique_ptr<ByteSink> sink,
                                                 const McapWriterOptions& options = {});

  /// Return the identifier. Errors: more than 65535 of them, or a text longer than 4 GB.
  [[nodiscard]] Result<std::uint16_t> add_schema(const std::string& name,
                                                 const std::string& encoding,
                                                 const std::string& data);
  /// Error: no such schema, and as above.
  [[nodiscard]] Result<std::uint16_t> add_channel(const std::string& topic,
                                                  const std::string& message_encoding,
                                                  std::uint16_t schema = 0,
                                                  const McapMetadata& metadata = {});

  /// Adds a message. Errors: no such channel, a time before the clock's epoch (the file remains
  /// usable), or a write error.
  [[nodiscard]] Result<void> write(std::uint16_t channel, LogTime log_time, LogTime publish_time,
                                   std::string_view data);
  /// Key-value pairs about the whole recording; written at once.
  [[nodiscard]] Result<void> add_metadata(const std::string& name, const McapMetadata& pairs);

  /// Closes the chunk and passes it to the operating system: it survives a crash of the program.
  [[nodiscard]] Result<void> flush();
  /// Flushes; when this returns, the data survives a power failure.
  [[nodiscard]] Result<void> sync();
  /// Writes the summary and ends the file.
  [[nodiscard]] Result<void> close();

  /// Of what was written so far.
  [[nodiscard]] const McapStatistics& statistics() const;
  [[nodiscard]] std::uint64_t bytes_written() const;  ///< flushed bytes only

 private:
  struct Impl;
  explicit McapWriter(detail::Owned<Impl> impl);

  detail::Owned<Impl> impl_;
};

}  // namespace wayfare::io
