#pragma once

// The destination of a byte stream: a file, or a test double.

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
  /// Appends all of `bytes`, or none of them on an error.
  [[nodiscard]] virtual Result<void> write(std::string_view bytes) = 0;
  /// When this returns, written data survives a power failure.
  [[nodiscard]] virtual Result<void> sync() = 0;
};

/// A file written from its start on. A failed write is undone, so that the file ends with the last
/// successful one.
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
