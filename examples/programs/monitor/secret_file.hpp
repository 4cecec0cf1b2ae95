#pragma once

#include <fcntl.h>
#include <unistd.h>

#include <string>
#include <utility>

#include <wayfare/core/result.hpp>
#include <wayfare/io/detail/descriptor.hpp>

namespace wayfare::examples {

/// A file with a secret, readable by this user only, during its lifetime.
class SecretFile {
 public:
  static Result<SecretFile> create(const std::string& path, const std::string& secret) {
    // An old one may have another mode, or be a link to another file.
    ::unlink(path.c_str());
    const io::Descriptor file(
        ::open(path.c_str(), O_CREAT | O_EXCL | O_WRONLY | O_NOFOLLOW | O_CLOEXEC, 0600));
    const std::string line = secret + "\n";
    if (file.get() < 0 ||
        ::write(file.get(), line.data(), line.size()) != static_cast<ssize_t>(line.size()))
      return io::system_error("cannot be written", path);
    return SecretFile(path);
  }
  SecretFile() = default;
  SecretFile(SecretFile&& other) noexcept : path_(std::exchange(other.path_, {})) {}
  SecretFile& operator=(SecretFile&& other) noexcept {
    std::swap(path_, other.path_);
    return *this;
  }
  ~SecretFile() {
    if (!path_.empty()) ::unlink(path_.c_str());
  }

 private:
  explicit SecretFile(std::string path) : path_(std::move(path)) {}
  std::string path_;
};

}  // namespace wayfare::examples
