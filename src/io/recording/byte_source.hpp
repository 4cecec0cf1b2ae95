#pragma once

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>

#include <wayfare/core/result.hpp>

namespace wayfare::io {

/// Random access to bytes of a file (up to its size when opened) or in memory.
class Source {
 public:
  explicit Source(std::string bytes) : bytes_(std::move(bytes)), size_(bytes_.size()) {}
  Source(const Source&) = delete;
  Source& operator=(const Source&) = delete;
  ~Source() {
    if (fd_ >= 0) ::close(fd_);
  }

  static Result<std::unique_ptr<Source>> open(const std::string& path) {
    const auto failed = [&](const char* what) {
      return Error{ErrorCode::io, std::string(what) + std::generic_category().message(errno), path};
    };
    const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
    if (fd < 0) return failed("cannot be opened: ");
    auto source = std::make_unique<Source>(std::string());
    source->fd_ = fd;
    struct stat status {};
    if (::fstat(fd, &status) != 0) return failed("cannot be examined: ");
    if (!S_ISREG(status.st_mode)) return Error{ErrorCode::io, "is not a regular file", path};
    source->size_ = static_cast<std::uint64_t>(status.st_size);
    return source;
  }

  [[nodiscard]] std::uint64_t size() const { return size_; }

  /// `n` bytes from `at` on, in `buffer` if they come from a file; nullopt where not all exist.
  std::optional<std::string_view> fetch(std::uint64_t at, std::uint64_t n,
                                        std::string& buffer) const {
    if (at > size_ || n > size_ - at) return std::nullopt;
    if (fd_ < 0) return std::string_view(bytes_).substr(at, n);
    buffer.resize(n);
    std::size_t got = 0;
    while (got < n) {
      const ssize_t r = ::pread(fd_, buffer.data() + got, n - got, static_cast<off_t>(at + got));
      if (r < 0 && errno == EINTR) continue;
      if (r <= 0) return std::nullopt;
      got += static_cast<std::size_t>(r);
    }
    return std::string_view(buffer);
  }

 private:
  std::string bytes_;
  int fd_ = -1;
  std::uint64_t size_ = 0;
};

}  // namespace wayfare::io
