#pragma once

// Serial lines, and pseudo-terminals that stand for them.

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <utility>

#include <wayfare/core/result.hpp>
#include <wayfare/io/detail/descriptor.hpp>

namespace wayfare::logger {

using io::Descriptor;

/// Setting of the modem line DTR, by which an RPLIDAR A1's adapter stops its motor.
enum class ModemLine {
  keep,  ///< as the driver sets it
  on,    ///< asserted
  off,   ///< not asserted
};

/// Settings of a line when it is opened.
struct SerialOptions {
  int baud = 115200;  ///< positive; any rate that the driver supports, not only the standard ones
  ModemLine dtr = ModemLine::keep;  ///< set when the line is opened
};

/// A raw POSIX serial line (8 data bits, no parity), which no other SerialPort shares. Works on
/// pseudo-terminals, which have neither a rate nor modem lines.
class SerialPort {
 public:
  /// Errors: cannot be opened, is no terminal, no positive rate; is in use by another SerialPort,
  /// with the number of its process. Bytes received before are kept.
  [[nodiscard]] static Result<SerialPort> open(const std::string& path,
                                               const SerialOptions& options = {});

  /// Waits up to `timeout` for bytes; returns their number, 0 after the timeout or where the buffer
  /// is empty. Error: the line is closed.
  [[nodiscard]] Result<std::size_t> read(std::span<std::uint8_t> buffer,
                                         std::chrono::milliseconds timeout);
  /// Writes without waiting; returns the number of bytes written.
  [[nodiscard]] Result<std::size_t> write(std::span<const std::uint8_t> bytes);

  /// Sets the modem line; false where there is none.
  bool set_dtr(ModemLine line);

  /// Bytes written that the line has not sent.
  [[nodiscard]] std::size_t unsent() const;

  /// Of the open line, for poll().
  [[nodiscard]] int descriptor() const { return fd_.get(); }
  /// Settings that failed without effect on reading: the rate, or a modem line.
  [[nodiscard]] const std::string& note() const { return note_; }

 private:
  SerialPort(Descriptor fd, std::string path) : fd_(std::move(fd)), path_(std::move(path)) {}

  Descriptor fd_;
  std::string path_, note_;
};

/// The process whose SerialPort has the line at `path`; nothing where none has it, or where the
/// system does not tell.
[[nodiscard]] std::optional<int> process_of_line(const std::string& path);

/// A pseudo-terminal: bytes written to it can be read from `path()` as a serial port.
class PseudoTerminal {
 public:
  /// Error (io): the system has no pseudo-terminal left.
  [[nodiscard]] static Result<PseudoTerminal> open();

  /// Path of the end that is opened as a port.
  [[nodiscard]] const std::string& path() const { return path_; }
  /// Writes until `timeout`; returns the number of bytes written.
  [[nodiscard]] Result<std::size_t> write(std::span<const std::uint8_t> bytes,
                                          std::chrono::milliseconds timeout);
  /// Bytes written by the other side; waits up to `timeout`.
  [[nodiscard]] Result<std::size_t> read(std::span<std::uint8_t> buffer,
                                         std::chrono::milliseconds timeout);
  /// Bytes written that the other end has not read.
  [[nodiscard]] std::size_t unread() const;

 private:
  PseudoTerminal() = default;

  Descriptor master_;
  Descriptor slave_;  ///< kept open, so that readers can open and close it
  std::string path_;
};

}  // namespace wayfare::logger
