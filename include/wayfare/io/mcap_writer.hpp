#pragma once

// MCAP recordings out: messages gathered in chunks, each with its checksum and the indexes of its
// messages, and a summary at the end. What was flushed can be read whatever happens next; the
// summary only makes reading quicker.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

#include <wayfare/core/result.hpp>
#include <wayfare/io/byte_sink.hpp>
#include <wayfare/io/mcap.hpp>

namespace wayfare::io {

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
