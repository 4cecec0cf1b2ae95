#pragma once

// ROS 1 bags in, without ROS: whole, never indexed, cut off or damaged, compressed or not. A file
// compressed as a whole by gzip is read into memory.

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <wayfare/core/result.hpp>
#include <wayfare/io/bag.hpp>
#include <wayfare/io/text_file.hpp>

namespace wayfare::io {

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

}  // namespace wayfare::io
