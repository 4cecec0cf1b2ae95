#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <utility>

#include <wayfare/io/detail/descriptor.hpp>
#include <wayfare/io/mcap.hpp>

namespace wayfare::examples {

/// A message; `old` if it was written before the file was opened, unless that was small then. Of
/// old messages only the last of each topic in a part of the file is passed on.
using TailSink = std::function<void(const io::McapMessage& message, bool old)>;

/// The messages of a growing recording in the order of the file.
class RecordingTail {
 public:
  explicit RecordingTail(std::string path) : path_(std::move(path)) {}

  [[nodiscard]] const std::string& path() const { return path_; }
  /// Passes on what was appended since the last call, up to about 8 MB. True if there is more.
  bool poll(const TailSink& sink);
  /// Of the messages read so far.
  [[nodiscard]] const io::McapContents& contents() const { return contents_; }

 private:
  [[nodiscard]] bool open();
  [[nodiscard]] bool read(std::uint64_t at, std::size_t size, std::string& to) const;
  void take(const std::string& records, bool old, const TailSink& sink);
  void describe(std::string_view records);

  const std::string path_;
  io::Descriptor file_;
  std::uint64_t next_ = 0;       ///< position of the next record
  std::uint64_t old_until_ = 0;  ///< messages before this position are old
  bool ended_ = false;           ///< the summary follows, or the file is damaged
  std::string described_;        ///< magic, and the records of schemas and channels so far
  io::McapContents contents_;
};

}  // namespace wayfare::examples
