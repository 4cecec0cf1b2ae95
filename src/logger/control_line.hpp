#pragma once

// The controllers of a logger: a serial line, and the clients of a Unix socket.

#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <wayfare/core/result.hpp>
#include <wayfare/logger/logger.hpp>
#include <wayfare/logger/serial_port.hpp>

namespace wayfare::logger {

class ControlLine {
 public:
  /// Either may be empty. Errors: the port cannot be opened, the socket cannot be created.
  static Result<ControlLine> open(const std::string& port, int baud, const std::string& socket);
  ControlLine(ControlLine&&) = default;
  ControlLine& operator=(ControlLine&&) = delete;
  ~ControlLine();

  /// Waits up to `timeout` for commands.
  void poll(std::chrono::milliseconds timeout, const std::function<void(Command)>& sink);
  /// To all clients; one that cannot take all of it at once is closed, and what it has sent obeyed. A
  /// serial line that has not sent the last one does not get it.
  void send(std::string_view line);

 private:
  ControlLine() = default;
  Result<void> listen(const std::string& path);
  void accept();
  /// False if the client has closed.
  static bool take(const Descriptor& client, const std::function<void(Command)>& sink);

  std::string port_path_, socket_path_;
  std::uint64_t device_ = 0, inode_ = 0;  // of the socket's file
  int baud_ = 0;
  std::optional<SerialPort> port_;
  Descriptor listener_;
  std::vector<Descriptor> clients_;
};

}  // namespace wayfare::logger
