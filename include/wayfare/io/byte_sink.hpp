#pragma once

// Where bytes go as they come: a file that grows, or what a test puts in its place.

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

#include <wayfare/core/result.hpp>
#include <wayfare/io/text_file.hpp>

namespace wayfare::io {

class ByteSink {
 public:
  virtual ~ByteSink() = default;
  /// Appends all of `bytes`, or on an error none of them.
  [[nodiscard]] virtual Result<void> write(std::string_view bytes) = 0;
  /// What was written outlives a power cut once this returns.
  [[nodiscard]] virtual Result<void> sync() = 0;
};

/// A file that grows. A write the disk has no room for is taken back, so that the file ends with
/// the last one that succeeded.
class FileSink final : public ByteSink {
 public:
  [[nodiscard]] static Result<std::unique_ptr<ByteSink>> create(const std::string& path,
                                                                const WriteOptions& options = {});
  FileSink(const FileSink&) = delete;
  FileSink& operator=(const FileSink&) = delete;
  ~FileSink() override;

  [[nodiscard]] Result<void> write(std::string_view bytes) override;
  [[nodiscard]] Result<void> sync() override;

 private:
  FileSink(int fd, std::string path) : fd_(fd), path_(std::move(path)) {}

  int fd_;
  std::string path_;
  std::uint64_t size_ = 0;
};

}  // namespace wayfare::io
