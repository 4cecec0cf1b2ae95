#pragma once

#include <poll.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <mutex>
#include <string>
#include <thread>
#include <utility>

#include <wayfare/logger/logger.hpp>
#include <wayfare/logger/serial_port.hpp>

namespace wayfare::examples {

/// The connection to a running logger: its control socket, or the other end of its control port.
/// Lost connections are reopened.
class LiveLink {
 public:
  /// `baud` of a serial line.
  explicit LiveLink(std::string path, int baud) : path_(std::move(path)), baud_(baud) {
    thread_ = std::thread([this] { run(); });
  }
  LiveLink(const LiveLink&) = delete;
  LiveLink& operator=(const LiveLink&) = delete;
  ~LiveLink() {
    {
      const std::lock_guard lock(mutex_);
      quit_ = true;
    }
    changed_.notify_all();
    thread_.join();
  }

  /// The latest status as JSON, once its number is above `seen`, which is then set to it; empty
  /// after `timeout`.
  [[nodiscard]] std::string wait(std::uint64_t& seen, std::chrono::milliseconds timeout) const {
    std::unique_lock lock(mutex_);
    if (!changed_.wait_for(lock, timeout, [&] { return quit_ || number_ > seen; }) || quit_)
      return {};
    seen = number_;
    return status_;
  }

  /// Why there is no status: the connection, or what arrives on it; empty while there is one.
  [[nodiscard]] std::string problem() const {
    const std::lock_guard lock(mutex_);
    if (std::chrono::steady_clock::now() < heard_ + kPatience) return {};
    if (fd_ < 0) return problem_;
    if (strange_bytes_ == 0)
      return path_ + ": connected, but nothing arrives: is the logger running?";
    return path_ + ": " + std::to_string(strange_bytes_) +
           " bytes without a status: another --baud, or no logger?";
  }

  /// False without a connection.
  [[nodiscard]] bool send(logger::Command command) {
    const std::lock_guard lock(mutex_);
    const char byte = static_cast<char>(command);
    return fd_ >= 0 && ::write(fd_, &byte, 1) == 1;
  }

 private:
  static constexpr std::chrono::seconds kPatience{3};

  [[nodiscard]] logger::Descriptor connect() const {
    struct stat there {};
    if (::stat(path_.c_str(), &there) != 0 || !S_ISSOCK(there.st_mode)) return logger::Descriptor();
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    if (path_.size() >= sizeof address.sun_path) return logger::Descriptor();
    std::memcpy(address.sun_path, path_.c_str(), path_.size());
    logger::Descriptor fd(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0));
    const auto* name = reinterpret_cast<const sockaddr*>(&address);
    return ::connect(fd.get(), name, sizeof address) == 0 ? std::move(fd) : logger::Descriptor();
  }

  void run() {
    while (true) {
      if (const logger::Descriptor socket = connect(); socket.get() >= 0) {
        read(socket.get());
      } else {
        const auto port = logger::SerialPort::open(path_, {baud_});
        if (port) read(port->descriptor());
        const std::lock_guard lock(mutex_);
        problem_ = port ? port->note() : port.error().to_string();
      }
      std::unique_lock lock(mutex_);
      if (changed_.wait_for(lock, std::chrono::milliseconds(500), [&] { return quit_; })) return;
    }
  }

  void read(int fd) {
    {
      const std::lock_guard lock(mutex_);
      fd_ = fd;
      strange_bytes_ = 0;
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
      {
        const std::lock_guard lock(mutex_);
        strange_bytes_ += static_cast<std::size_t>(n);
      }
      parse(text);
    }
    const std::lock_guard lock(mutex_);
    fd_ = -1;
  }

  void parse(std::string& text) {
    for (std::size_t end; (end = text.find('\n')) != text.npos; text.erase(0, end + 1)) {
      const auto status = logger::status_of_line(std::string_view(text).substr(0, end));
      if (!status) continue;
      {
        const std::lock_guard lock(mutex_);
        status_ = *status;
        ++number_;
        heard_ = std::chrono::steady_clock::now();
        strange_bytes_ = 0;
      }
      changed_.notify_all();
    }
    if (text.size() > 65536) text.clear();  // noise without line ends
  }

  const std::string path_;
  const int baud_;
  mutable std::mutex mutex_;
  mutable std::condition_variable changed_;
  std::string status_;
  std::uint64_t number_ = 0;
  std::chrono::steady_clock::time_point heard_ = std::chrono::steady_clock::now();
  std::string problem_;
  std::size_t strange_bytes_ = 0;  ///< since the last status
  int fd_ = -1;
  bool quit_ = false;
  std::thread thread_;
};

}  // namespace wayfare::examples
