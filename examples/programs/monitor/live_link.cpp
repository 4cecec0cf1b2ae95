#include "live_link.hpp"

#include <poll.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <cstring>
#include <optional>
#include <utility>

#include <wayfare/logger/serial_port.hpp>

namespace wayfare::examples {

LiveLink::LiveLink(std::string path) : path_(std::move(path)) {
  thread_ = std::thread([this] { run(); });
}

LiveLink::~LiveLink() {
  {
    const std::lock_guard lock(mutex_);
    quit_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

std::string LiveLink::wait(std::uint64_t& seen, std::chrono::milliseconds timeout) const {
  std::unique_lock lock(mutex_);
  if (!changed_.wait_for(lock, timeout, [&] { return quit_ || number_ > seen; }) || quit_)
    return {};
  seen = number_;
  return status_;
}

bool LiveLink::send(logger::Command command) {
  const std::lock_guard lock(mutex_);
  const char byte = static_cast<char>(command);
  return fd_ >= 0 && ::write(fd_, &byte, 1) == 1;
}

int LiveLink::connect() const {
  struct stat there {};
  if (::stat(path_.c_str(), &there) != 0 || !S_ISSOCK(there.st_mode)) return -1;
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (path_.size() >= sizeof address.sun_path) return -1;
  std::memcpy(address.sun_path, path_.c_str(), path_.size());
  const int fd = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  if (fd >= 0 && ::connect(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0)
    return fd;
  if (fd >= 0) ::close(fd);
  return -1;
}

void LiveLink::run() {
  while (true) {
    const int socket = connect();
    std::optional<logger::SerialPort> port;
    if (socket < 0)
      if (auto opened = logger::SerialPort::open(path_, {57600, logger::ModemLine::keep}))
        port.emplace(std::move(*opened));
    const int fd = socket >= 0 ? socket : port ? port->descriptor() : -1;
    if (fd >= 0) read(fd);
    if (socket >= 0) ::close(socket);
    std::unique_lock lock(mutex_);
    if (changed_.wait_for(lock, std::chrono::milliseconds(500), [&] { return quit_; })) return;
  }
}

void LiveLink::read(int fd) {
  {
    const std::lock_guard lock(mutex_);
    fd_ = fd;
  }
  static_cast<void>(send(logger::Command::check));
  std::string text;
  while (true) {
    pollfd p{fd, POLLIN, 0};
    const int ready = ::poll(&p, 1, 100);
    {
      const std::lock_guard lock(mutex_);
      if (quit_) break;
    }
    if (ready <= 0) continue;
    char buffer[4096];
    const ssize_t n = ::read(fd, buffer, sizeof buffer);
    if (n <= 0) break;
    text.append(buffer, static_cast<std::size_t>(n));
    parse(text);
  }
  const std::lock_guard lock(mutex_);
  fd_ = -1;
}

void LiveLink::parse(std::string& text) {
  for (std::size_t end; (end = text.find('\n')) != text.npos; text.erase(0, end + 1)) {
    const auto status = logger::status_of_line(std::string_view(text).substr(0, end));
    if (!status) continue;
    {
      const std::lock_guard lock(mutex_);
      status_ = *status;
      ++number_;
    }
    changed_.notify_all();
  }
  if (text.size() > 65536) text.clear();  // noise without line ends
}

}  // namespace wayfare::examples
