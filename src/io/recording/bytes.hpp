#pragma once

// The bytes of recordings: little-endian numbers, random access to a file, compressed blocks (LZ4
// frames, Zstandard frames, bzip2 streams).

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include <wayfare/core/result.hpp>
#include <wayfare/io/detail/descriptor.hpp>

namespace wayfare::io {

template <std::unsigned_integral T>
void put(std::string& out, T value) {
  for (std::size_t i = 0; i < sizeof(T); ++i)
    out += static_cast<char>(static_cast<std::uint8_t>(std::uint64_t{value} >> (8 * i)));
}

/// Preceded by its length in four bytes.
inline void put(std::string& out, std::string_view text) {
  put(out, static_cast<std::uint32_t>(text.size()));
  out += text;
}

/// Numbers and texts one after the other.
template <class... Values>
[[nodiscard]] std::string packed(const Values&... values) {
  std::string out;
  (put(out, values), ...);
  return out;
}

/// Reads numbers, and texts preceded by their length. Past the end all values are zero or empty and
/// `ok` is false.
class ByteCursor {
 public:
  explicit ByteCursor(std::string_view bytes) : rest_(bytes) {}

  template <std::unsigned_integral T>
  T number() {
    const std::string_view b = bytes(sizeof(T));
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < b.size(); ++i)
      value |= std::uint64_t{static_cast<std::uint8_t>(b[i])} << (8 * i);
    return static_cast<T>(value);
  }

  std::string_view bytes(std::uint64_t n) {
    if (n > rest_.size()) {
      ok_ = false;
      rest_ = {};
      return {};
    }
    const std::string_view taken = rest_.substr(0, static_cast<std::size_t>(n));
    rest_.remove_prefix(taken.size());
    return taken;
  }

  std::string_view text() { return bytes(number<std::uint32_t>()); }

  [[nodiscard]] bool ok() const { return ok_; }
  [[nodiscard]] bool at_end() const { return rest_.empty(); }
  [[nodiscard]] std::string_view rest() const { return rest_; }

 protected:
  void fail() { ok_ = false; }

 private:
  std::string_view rest_;
  bool ok_ = true;
};

/// Random access to bytes of a file (up to its size when opened) or in memory.
class Source {
 public:
  explicit Source(std::string bytes) : bytes_(std::move(bytes)), size_(bytes_.size()) {}

  static Result<std::unique_ptr<Source>> open(const std::string& path) {
    // Opening a pipe would otherwise wait for its writer.
    Descriptor fd(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
    if (fd.get() < 0) return system_error("cannot be opened", path);
    struct stat status {};
    if (::fstat(fd.get(), &status) != 0) return system_error("cannot be examined", path);
    if (!S_ISREG(status.st_mode)) return Error{ErrorCode::io, "is not a regular file", path};
    auto source = std::make_unique<Source>(std::string());
    source->fd_ = std::move(fd);
    source->size_ = static_cast<std::uint64_t>(status.st_size);
    return source;
  }

  [[nodiscard]] std::uint64_t size() const { return size_; }

  /// `n` bytes from `at` on, in `buffer` if they come from a file; nullopt where not all exist.
  std::optional<std::string_view> fetch(std::uint64_t at, std::uint64_t n,
                                        std::string& buffer) const {
    if (at > size_ || n > size_ - at || n > buffer.max_size()) return std::nullopt;
    const auto length = static_cast<std::size_t>(n);
    if (fd_.get() < 0) return std::string_view(bytes_).substr(static_cast<std::size_t>(at), length);
    buffer.resize(length);
    std::size_t got = 0;
    while (got < length) {
      const ssize_t r =
          ::pread(fd_.get(), buffer.data() + got, length - got, static_cast<off_t>(at + got));
      if (r < 0 && errno == EINTR) continue;
      if (r <= 0) return std::nullopt;
      got += static_cast<std::size_t>(r);
    }
    return std::string_view(buffer);
  }

 private:
  std::string bytes_;
  Descriptor fd_;
  std::uint64_t size_ = 0;
};

/// Decompresses `bytes`, compressed by `name` ("lz4", "zstd" or "bz2"), to `size` bytes. Allocates
/// `size` bytes. Errors: damaged, or another size; a compression that is unknown or not supported
/// by this build.
[[nodiscard]] Result<std::string> decompress_block(std::string_view name, std::string_view bytes,
                                                   std::size_t size);

/// A fault at a byte of the file `name`.
[[nodiscard]] inline Error fault_at(std::uint64_t at, std::string message, const std::string& name,
                                    ErrorCode code = ErrorCode::parse) {
  return {code, std::move(message), name, 0, static_cast<std::size_t>(at)};
}

}  // namespace wayfare::io
