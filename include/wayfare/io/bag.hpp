#pragma once

// What a ROS 1 bag (format 2.0, "#ROSBAG V2.0") is made of: connections, each of one topic and one
// kind of message, and the messages that came by them.

// ROS 1 bags in, without ROS: whole, never indexed, cut off or damaged, compressed or not. A file
// compressed as a whole by gzip is read into memory.

// ROS 1 bags out, without ROS: chunks that are not compressed, and the index every ROS tool wants.

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include <wayfare/core/result.hpp>
#include <wayfare/core/time.hpp>
#include <wayfare/io/text_file.hpp>

namespace wayfare::io {

struct BagConnection {
  std::uint32_t id = 0;
  std::string topic = {};
  std::string type = {};        ///< such as sensor_msgs/Imu
  std::string md5 = {};         ///< of the type's definition
  std::string definition = {};  ///< of the type and of those within it
  bool latching = false;        ///< the last message is repeated to whoever comes late
};

/// One message as a reader delivers it; `connection` and `data` are gone when the callable returns.
struct BagMessage {
  const BagConnection* connection = nullptr;
  LogTime time;  ///< when it was received
  std::string_view data;
};

struct BagReadOptions {
  /// Chunks and other records larger than this are not read; memory is bounded by it.
  std::size_t max_record_bytes = std::size_t{1} << 28;
  std::size_t max_problems = 100;  ///< kept in full; all are counted
};

/// What is in a bag, from its index; where that is missing or damaged, from the data.
struct BagContents {
  std::vector<BagConnection> connections;  ///< in order of their identifiers
  std::uint64_t messages = 0;
  std::uint64_t bytes = 0;  ///< of the file when it was opened
  bool indexed = false;     ///< the file's own index was used
  Problems problems;        ///< with the byte where each was met
};

/// A bag opened for reading.
class BagReader {
 public:
  /// Errors: cannot be read; does not begin as a bag of version 2.0 does. Anything else that is
  /// wrong is a problem in `contents`.
  [[nodiscard]] static Result<BagReader> open(const std::string& path,
                                              const BagReadOptions& options = {});
  /// The same of bytes in memory; `source` names them in messages.
  [[nodiscard]] static Result<BagReader> parse(std::string bytes, const std::string& source,
                                               const BagReadOptions& options = {});
  BagReader(BagReader&&) noexcept;
  BagReader& operator=(BagReader&&) noexcept;
  ~BagReader();

  [[nodiscard]] const BagContents& contents() const;

  /// Calls `sink` with all messages as they stand in the file until it returns false. What was met
  /// on the way: damaged records and chunks are left out, as are messages of connections never
  /// described; reading goes on at the next chunk.
  Problems read(const std::function<bool(const BagMessage&)>& sink) const;

 private:
  struct Impl;
  explicit BagReader(std::unique_ptr<Impl> impl);
  [[nodiscard]] static Result<BagReader> from(std::unique_ptr<Impl> impl);

  std::unique_ptr<Impl> impl_;
};

/// Gathers a bag in memory: the head of the file says where its index is, so nothing is whole
/// before the end. For recordings as they are made there is MCAP.
class BagWriter {
 public:
  explicit BagWriter(std::size_t chunk_bytes = std::size_t{768} << 10U);

  /// The identifier to refer to it by; `connection.id` is not looked at.
  std::uint32_t add_connection(BagConnection connection);

  /// Errors: no such connection; a time before 1970 or after 2106.
  [[nodiscard]] Result<void> write(std::uint32_t connection, LogTime time, std::string_view data);

  /// The bag's bytes. No more can be written.
  [[nodiscard]] std::string finish();

 private:
  struct Entry {
    std::uint64_t time;  ///< as it stands in the file
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
  std::vector<bool> described_;  ///< in some chunk already
  std::string out_, chunk_;
  Chunk open_;
  std::map<std::uint32_t, std::vector<Entry>> entries_;
  std::vector<Chunk> chunks_;
};

}  // namespace wayfare::io
