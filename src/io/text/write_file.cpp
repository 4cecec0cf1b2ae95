#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <memory>
#include <utility>

#include <wayfare/io/text_file.hpp>

#include "io/text/file_parts.hpp"

namespace wayfare::io {
namespace {

Error already_exists(const std::string& path) {
  return Error{ErrorCode::io, "exists already; not overwritten", path};
}

/// Writes `bytes` and removes what has been written from them; false on an error.
bool write_some(int fd, std::string_view& bytes) {
  while (!bytes.empty()) {
    const ssize_t put = ::write(fd, bytes.data(), bytes.size());
    if (put < 0 && errno == EINTR) continue;
    if (put < 0) return false;
    bytes.remove_prefix(static_cast<std::size_t>(put));
  }
  return true;
}

/// Calls `produce` with a function that appends to `file`, and closes it.
Result<void> write_all(Descriptor& file, const FileParts& produce, const std::string& path) {
  bool written = true;
  produce([&](std::string_view part) { return written = written && write_some(file.get(), part); });
  if (!written || file.close() != 0) return system_error("cannot be written", path);
  return {};
}

/// Gives the finished file its name; unless it may be replaced, `link` fails for an existing file.
Result<void> rename_to_target(const std::string& temporary, const std::string& path,
                              Existing existing) {
  const bool replace = existing == Existing::replace;
  const int code =
      replace ? ::rename(temporary.c_str(), path.c_str()) : ::link(temporary.c_str(), path.c_str());
  if (code == 0) {
    if (!replace) ::unlink(temporary.c_str());
    return {};
  }
  if (errno == EEXIST) return already_exists(path);
  if (!replace && ::access(path.c_str(), F_OK) != 0 &&
      ::rename(temporary.c_str(), path.c_str()) == 0) {
    return {};  // a file system without hard links
  }
  return system_error("cannot be put in place", path);
}

/// Devices and pipes are written to directly, not replaced by a file.
Result<void> write_into(const std::string& path, const FileParts& produce) {
  Descriptor file(::open(path.c_str(), O_WRONLY | O_CLOEXEC));
  if (file.get() < 0) return system_error("cannot be opened for writing", path);
  return write_all(file, produce, path);
}

/// Creates a new file beside `path` and stores its name in `name`.
int create_beside(const std::string& path, std::string& name) {
  for (int attempt = 0; attempt < 100; ++attempt) {
    name = path + "." + std::to_string(::getpid()) + "-" + std::to_string(attempt) + ".part";
    const int fd = ::open(name.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (fd >= 0 || errno != EEXIST) return fd;
  }
  return -1;
}

/// The target of a chain of symbolic links, which is written instead of the link.
std::string resolved(const std::string& path) {
  const std::unique_ptr<char, decltype(&std::free)> real(::realpath(path.c_str(), nullptr),
                                                         &std::free);
  return real ? std::string(real.get()) : path;
}

}  // namespace

Result<void> write_file_parts(const std::string& path, const FileParts& produce,
                              const WriteOptions& options) {
  struct stat status {};
  const bool exists = ::stat(path.c_str(), &status) == 0;
  if (exists && S_ISDIR(status.st_mode)) return Error{ErrorCode::io, "is a folder", path};
  if (exists && !S_ISREG(status.st_mode)) return write_into(path, produce);
  if (exists && options.existing == Existing::refuse) return already_exists(path);
  const std::string target = exists ? resolved(path) : path;
  std::string temporary;
  Descriptor file(create_beside(target, temporary));
  if (file.get() < 0) return system_error("cannot be created", path);
  Result<void> done = write_all(file, produce, path);
  if (done) done = rename_to_target(temporary, target, options.existing);
  if (!done) ::unlink(temporary.c_str());
  return done;
}

Result<void> write_file(const std::string& path, std::string_view bytes,
                        const WriteOptions& options) {
  return write_file_parts(
      path, [&](const AppendPart& append) { append(bytes); }, options);
}

Result<std::unique_ptr<ByteSink>> FileSink::create(const std::string& path,
                                                   const WriteOptions& options) {
  const int mode = options.existing == Existing::refuse ? O_EXCL : O_TRUNC;
  Descriptor file(::open(path.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC | mode, 0666));
  if (file.get() < 0 && errno == EEXIST) return already_exists(path);
  if (file.get() < 0) return system_error("cannot be created", path);
  return std::unique_ptr<ByteSink>(new FileSink(std::move(file), path));
}

Result<void> FileSink::write(std::string_view bytes) {
  const std::size_t all = bytes.size();
  if (!write_some(file_.get(), bytes)) {
    Error failed = system_error("cannot be written", path_);
    // Removes the incomplete record at the end.
    if (all != bytes.size() && ::ftruncate(file_.get(), static_cast<off_t>(size_)) == 0)
      ::lseek(file_.get(), static_cast<off_t>(size_), SEEK_SET);
    return failed;
  }
  size_ += all;
  return {};
}

Result<void> FileSink::sync() {
  // EINVAL: the device does not support syncing.
  if (::fdatasync(file_.get()) != 0 && errno != EINVAL)
    return system_error("cannot be synced", path_);
  return {};
}

}  // namespace wayfare::io
