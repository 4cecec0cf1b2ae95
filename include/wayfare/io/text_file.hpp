#pragma once

// Reading and writing whole files. Gzip is decompressed on reading; writing is atomic.
//
// The destination of a byte stream: a file, or a test double.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <wayfare/core/result.hpp>

namespace wayfare::io {

struct ReadOptions {
  /// Limit of the content, bytes after decompression; a larger file is an error.
  std::size_t max_bytes = std::size_t{1} << 30;
};

/// A file's bytes, decompressed if it was gzip.
struct FileContent {
  std::string bytes;
  bool was_gzip = false;
  /// Set where a gzip stream is truncated or damaged: `bytes` then contains the data before that.
  std::optional<Error> damage;
};

/// Reads all of `path`. Errors: cannot be opened or read, is a folder, is larger than allowed.
[[nodiscard]] Result<FileContent> read_file(const std::string& path,
                                            const ReadOptions& options = {});

/// The same for bytes in memory; `source` names them in messages.
[[nodiscard]] Result<FileContent> decompress(std::string_view bytes, const std::string& source,
                                             const ReadOptions& options = {});

/// What to do if the file to be written exists.
enum class Existing { refuse, replace };

struct WriteOptions {
  Existing existing = Existing::refuse;
};

/// Writes `bytes` to a temporary file beside `path` and renames it there, so that `path` never
/// contains only part of them, even if the disk is full.
[[nodiscard]] Result<void> write_file(const std::string& path, std::string_view bytes,
                                      const WriteOptions& options = {});

/// The faults found while reading that were not fatal: their number, and the first ones in full.
class Problems {
 public:
  Problems() = default;
  explicit Problems(std::size_t capacity) : capacity_(capacity) {}

  void add(Error error) {
    ++count_;
    if (first_.size() < capacity_) first_.push_back(std::move(error));
  }

  [[nodiscard]] std::size_t count() const { return count_; }
  [[nodiscard]] bool empty() const { return count_ == 0; }
  /// In the order of the file.
  [[nodiscard]] const std::vector<Error>& first() const { return first_; }

 private:
  std::size_t capacity_ = 100;
  std::size_t count_ = 0;
  std::vector<Error> first_;
};

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
