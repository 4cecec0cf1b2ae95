#pragma once

// Reading and writing ROS 1 bags (format 2.0, "#ROSBAG V2.0") without ROS. A bag contains
// connections, each of one topic and one message type, and their messages. The reader accepts bags
// that are not indexed, truncated, damaged or compressed; a file compressed as a whole by gzip is
// read into memory. The writer writes uncompressed chunks and the index.

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <wayfare/core/result.hpp>
#include <wayfare/core/time.hpp>
#include <wayfare/io/text_file.hpp>

namespace wayfare::io {

/// A topic of a bag and the type of its messages.
struct BagConnection {
  std::uint32_t id = 0;         ///< given by the writer
  std::string topic = {};       ///< such as /scan
  std::string type = {};        ///< such as sensor_msgs/Imu
  std::string md5 = {};         ///< of the type's definition
  std::string definition = {};  ///< of the type and its nested types
  bool latching = false;        ///< late subscribers receive the last message
};

/// One message; `connection` and `data` are valid until the reader's callable returns.
struct BagMessage {
  const BagConnection* connection = nullptr;  ///< its topic and type
  LogTime time;                               ///< when it was received
  std::string_view data;                      ///< serialised message
};

/// Limits of a BagReader.
struct BagReadOptions {
  /// Larger chunks and records are not read; this bounds the memory.
  std::size_t max_record_bytes = std::size_t{1} << 28;
  std::size_t max_problems = 100;  ///< kept in full; all are counted
};

/// The contents of a bag from its index, or from the data where the index is missing or damaged.
struct BagContents {
  std::vector<BagConnection> connections;  ///< in order of their identifiers
  std::uint64_t messages = 0;              ///< number of all
  std::uint64_t bytes = 0;                 ///< of the file when it was opened
  bool indexed = false;                    ///< the file's own index was used
  Problems problems;                       ///< each with its byte offset
};

/// A bag opened for reading; copies share it.
class BagReader {
 public:
  /// Errors: cannot be read; does not begin as a bag of version 2.0 does. Everything else is
  /// reported as a problem in `contents`.
  [[nodiscard]] static Result<BagReader> open(const std::string& path,
                                              const BagReadOptions& options = {});
  /// The same for bytes in memory; `source` names them in messages.
  [[nodiscard]] static Result<BagReader> parse(std::string bytes, const std::string& source,
                                               const BagReadOptions& options = {});

  /// As found when the bag was opened.
  [[nodiscard]] const BagContents& contents() const;

  /// Calls `sink` with all messages in the order of the file until it returns false. Returns the
  /// problems: damaged records and chunks and messages of undescribed connections are skipped;
  /// reading continues at the next chunk.
  Problems read(const std::function<bool(const BagMessage&)>& sink) const;

 private:
  struct Impl;
  explicit BagReader(std::shared_ptr<const Impl> impl) : impl_(std::move(impl)) {}
  [[nodiscard]] static Result<BagReader> from(std::shared_ptr<Impl> impl);

  std::shared_ptr<const Impl> impl_;
};

/// Builds a bag in memory: the head of the file contains the position of its index, so that it is
/// complete only at the end. For live recording, use MCAP.
class BagWriter {
 public:
  /// An empty bag; a chunk is closed once it has `chunk_bytes`.
  explicit BagWriter(std::size_t chunk_bytes = std::size_t{768} << 10U);

  /// Returns the identifier of the connection; `connection.id` is ignored.
  std::uint32_t add_connection(BagConnection connection);

  /// Errors: no such connection; a time before 1970 or after 2106; the bag is finished.
  [[nodiscard]] Result<void> write(std::uint32_t connection, LogTime time, std::string_view data);

  /// Returns the bag's bytes and ends it; nothing the next time.
  [[nodiscard]] std::string finish();

 private:
  struct Entry {
    std::uint64_t time;  ///< in the file's encoding
    std::uint32_t offset;
  };
  struct Chunk {
    std::uint64_t at = 0;
    LogTime first, last;
    std::map<std::uint32_t, std::uint32_t> counts;
  };

  void close_chunk();

  std::size_t chunk_bytes_;
  std::vector<BagConnection> connections_;
  std::vector<bool> described_;  ///< whether a chunk already describes it
  std::string out_, chunk_;
  Chunk open_;
  std::map<std::uint32_t, std::vector<Entry>> entries_;
  std::vector<Chunk> chunks_;
  bool finished_ = false;
};

}  // namespace wayfare::io
