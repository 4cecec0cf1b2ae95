#pragma once

#include <unistd.h>

#include <cerrno>
#include <string>
#include <system_error>
#include <utility>

#include <wayfare/core/result.hpp>

namespace wayfare::detail {

/// Owns an open file, terminal or socket; -1: none.
class Descriptor {
 public:
  explicit Descriptor(int fd = -1) : fd_(fd) {}
  Descriptor(Descriptor&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
  Descriptor& operator=(Descriptor&& other) noexcept {
    std::swap(fd_, other.fd_);
    return *this;
  }
  ~Descriptor() { close(); }

  [[nodiscard]] int get() const { return fd_; }
  /// 0 on success; a full network disk may report its error only here.
  int close() { return fd_ < 0 ? 0 : ::close(std::exchange(fd_, -1)); }

 private:
  int fd_;
};

/// What failed at `path`, with the reason in errno.
[[nodiscard]] inline Error system_error(const std::string& what, const std::string& path) {
  return {ErrorCode::io, what + ": " + std::generic_category().message(errno), path};
}

}  // namespace wayfare::detail
