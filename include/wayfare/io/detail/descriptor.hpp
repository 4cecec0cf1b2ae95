#pragma once

#include <string>
#include <utility>

#include <wayfare/core/result.hpp>

namespace wayfare::io {

/// Owns an open file, terminal or socket; -1: none.
class Descriptor {
 public:
  /// Takes the ownership of `fd`.
  explicit Descriptor(int fd = -1) : fd_(fd) {}
  /// Leaves the other without a descriptor.
  Descriptor(Descriptor&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
  /// Swaps the descriptors.
  Descriptor& operator=(Descriptor&& other) noexcept {
    std::swap(fd_, other.fd_);
    return *this;
  }
  ~Descriptor() { close(); }

  /// For system calls; -1: none.
  [[nodiscard]] int get() const { return fd_; }
  /// 0 on success; a full network disk may report its error only here.
  int close();

 private:
  int fd_;
};

/// What failed at `path`, with the reason in errno.
[[nodiscard]] Error system_error(const std::string& what, const std::string& path);

}  // namespace wayfare::io
