#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>

#include <wayfare/io/text_file.hpp>

namespace wayfare::io {
namespace {

Error system_error(const char* what, const std::string& path) {
  return Error{ErrorCode::io, std::string(what) + ": " + std::generic_category().message(errno),
               path};
}

}  // namespace

Result<std::unique_ptr<ByteSink>> FileSink::create(const std::string& path,
                                                   const WriteOptions& options) {
  const int mode = options.existing == Existing::refuse ? O_EXCL : O_TRUNC;
  const int fd = ::open(path.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC | mode, 0666);
  if (fd < 0 && errno == EEXIST)
    return Error{ErrorCode::io, "exists already; not overwritten", path};
  if (fd < 0) return system_error("cannot be created", path);
  return std::unique_ptr<ByteSink>(new FileSink(fd, path));
}

FileSink::~FileSink() { ::close(fd_); }

Result<void> FileSink::write(std::string_view bytes) {
  const std::size_t all = bytes.size();
  while (!bytes.empty()) {
    const ssize_t n = ::write(fd_, bytes.data(), bytes.size());
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) {
      Error failed = system_error("cannot be written", path_);
      // Removes the incomplete record at the end.
      if (all != bytes.size() && ::ftruncate(fd_, static_cast<off_t>(size_)) == 0)
        ::lseek(fd_, static_cast<off_t>(size_), SEEK_SET);
      return failed;
    }
    bytes.remove_prefix(static_cast<std::size_t>(n));
  }
  size_ += all;
  return {};
}

Result<void> FileSink::sync() {
  // EINVAL: the device does not support syncing.
  if (::fdatasync(fd_) != 0 && errno != EINVAL) return system_error("cannot be synced", path_);
  return {};
}

}  // namespace wayfare::io
