#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <string>
#include <thread>

#include <wayfare/logger/logger.hpp>

namespace wayfare::examples {

/// The connection to a running logger: its control socket, or the other end of its control port.
/// Lost connections are reopened.
class LiveLink {
 public:
  explicit LiveLink(std::string path);
  LiveLink(const LiveLink&) = delete;
  LiveLink& operator=(const LiveLink&) = delete;
  ~LiveLink();

  /// The latest status as JSON, once its number is above `seen`, which is then set to it; empty
  /// after `timeout`.
  [[nodiscard]] std::string wait(std::uint64_t& seen, std::chrono::milliseconds timeout) const;
  /// False without a connection.
  [[nodiscard]] bool send(logger::Command command);

 private:
  void run();
  [[nodiscard]] int connect() const;
  void read(int fd);
  void parse(std::string& text);

  const std::string path_;
  mutable std::mutex mutex_;
  mutable std::condition_variable changed_;
  std::string status_;
  std::uint64_t number_ = 0;
  int fd_ = -1;
  bool quit_ = false;
  std::thread thread_;
};

}  // namespace wayfare::examples
