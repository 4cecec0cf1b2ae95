#pragma once

// ROS 1 bags out, without ROS: chunks that are not compressed, and the index every ROS tool wants.

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include <wayfare/core/result.hpp>
#include <wayfare/io/bag.hpp>

namespace wayfare::io {

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
