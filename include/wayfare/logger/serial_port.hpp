#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include <wayfare/core/result.hpp>

namespace wayfare::logger {

/// What to do with the modem line DTR, with which an RPLIDAR A1's adapter stops its motor.
enum class ModemLine { keep, on, off };

struct SerialOptions {
  int baud = 115200;  ///< any rate the driver can do, not only the usual ones
  ModemLine dtr = ModemLine::keep;
};

/// A serial line without any processing of its bytes (8 data bits, no parity), by POSIX. Works on
/// pseudo-terminals, which have neither a rate nor modem lines.
class SerialPort {
 public:
  /// Errors: cannot be opened, is no terminal. What waits in the line already is kept.
  [[nodiscard]] static Result<SerialPort> open(const std::string& path,
                                               const SerialOptions& options = {});
  SerialPort(SerialPort&& other) noexcept;
  SerialPort& operator=(SerialPort&& other) noexcept;
  ~SerialPort();

  /// Waits up to `timeout` for bytes; gives how many came, 0 where none did. Error: the line is
  /// gone.
  [[nodiscard]] Result<std::size_t> read(std::span<std::uint8_t> buffer,
                                         std::chrono::milliseconds timeout);
  /// Writes what the line takes at once; gives how much that was.
  [[nodiscard]] Result<std::size_t> write(std::span<const std::uint8_t> bytes);

  [[nodiscard]] int descriptor() const { return fd_; }
  /// What did not work but does not matter for reading: the rate, or a modem line.
  [[nodiscard]] const std::string& note() const { return note_; }

 private:
  SerialPort(int fd, std::string path) : fd_(fd), path_(std::move(path)) {}

  int fd_ = -1;
  std::string path_, note_;
};

/// A pseudo-terminal: what is written to it is read by whoever opens `path()` as a serial port.
class PseudoTerminal {
 public:
  [[nodiscard]] static Result<PseudoTerminal> open();
  PseudoTerminal(PseudoTerminal&& other) noexcept;
  PseudoTerminal& operator=(PseudoTerminal&& other) noexcept;
  ~PseudoTerminal();

  [[nodiscard]] const std::string& path() const { return path_; }
  /// Writes what there is room for within `timeout`; gives how much that was.
  [[nodiscard]] Result<std::size_t> write(std::span<const std::uint8_t> bytes,
                                          std::chrono::milliseconds timeout);
  /// What the other side wrote; waits up to `timeout`.
  [[nodiscard]] Result<std::size_t> read(std::span<std::uint8_t> buffer,
                                         std::chrono::milliseconds timeout);
  /// Bytes written that were not read at the other end yet.
  [[nodiscard]] std::size_t unread() const;

 private:
  PseudoTerminal() = default;
  void close();

  int master_ = -1;
  int slave_ = -1;  ///< kept open, so that a reader may come and go
  std::string path_;
};

}  // namespace wayfare::logger
