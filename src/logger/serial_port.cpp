// Not <termios.h>: the kernel's own structure, which that does not declare, supports any rate.
#include <asm/termbits.h>
#include <fcntl.h>
#include <poll.h>
#include <stdlib.h>
#include <sys/file.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <fstream>
#include <limits>
#include <thread>
#include <utility>

#include <wayfare/core/contract.hpp>
#include <wayfare/logger/device_decoder.hpp>
#include <wayfare/logger/serial_port.hpp>

namespace wayfare::logger {

using io::system_error;

namespace {

/// No echo, no line editing, no flow control, no translation: all 256 byte values pass. False if it
/// is no terminal.
bool make_raw(int fd, int baud, std::string& note) {
  struct termios2 t {};
  if (::ioctl(fd, TCGETS2, &t) != 0) return false;
  t.c_iflag &= ~static_cast<tcflag_t>(IGNBRK | BRKINT | PARMRK | ISTRIP | INLCR | IGNCR | ICRNL |
                                      IXON | IXOFF | IXANY | INPCK);
  t.c_oflag &= ~static_cast<tcflag_t>(OPOST);
  t.c_lflag &= ~static_cast<tcflag_t>(ECHO | ECHONL | ICANON | ISIG | IEXTEN);
  t.c_cflag &=
      ~static_cast<tcflag_t>(CSIZE | PARENB | CSTOPB | CRTSCTS | CBAUD | (CBAUD << IBSHIFT));
  t.c_cflag |= CS8 | CREAD | CLOCAL | BOTHER | (BOTHER << IBSHIFT);
  t.c_ispeed = t.c_ospeed = static_cast<speed_t>(baud);
  t.c_cc[VMIN] = 1;
  t.c_cc[VTIME] = 0;
  if (::ioctl(fd, TCSETS2, &t) != 0) note = "the rate of " + std::to_string(baud) + " is not taken";
  return true;
}

/// False if another SerialPort has the line. Locks are released when a program ends, however it
/// ends.
bool lock(int fd) {
  if (::flock(fd, LOCK_EX | LOCK_NB) != 0) return errno != EWOULDBLOCK;
  // Programs that ask for no lock are kept out, too. Not of a pseudo-terminal: its other end keeps
  // it open, and with it this flag when the program has ended.
  constexpr unsigned kFirstPty = 136, kLastPty = 143;
  struct stat line {};
  const bool pty = ::fstat(fd, &line) == 0 && major(line.st_rdev) >= kFirstPty &&
                   major(line.st_rdev) <= kLastPty;
  if (!pty) ::ioctl(fd, TIOCEXCL);
  return true;
}

Error in_use(const std::string& path) {
  const auto process = process_of_line(path);
  return {
      ErrorCode::io,
      process ? "is in use by process " + std::to_string(*process) : "is in use by another program",
      path};
}

/// Within what poll() waits for; a negative number would mean for ever.
std::chrono::milliseconds waitable(std::chrono::milliseconds timeout) {
  return std::clamp(timeout, std::chrono::milliseconds(0),
                    std::chrono::milliseconds(std::numeric_limits<int>::max()));
}

Result<std::size_t> read_some(int fd, std::span<std::uint8_t> buffer,
                              std::chrono::milliseconds timeout, const std::string& path) {
  if (buffer.empty()) return std::size_t{0};
  pollfd p{fd, POLLIN, 0};
  const int ready = ::poll(&p, 1, static_cast<int>(waitable(timeout).count()));
  if (ready < 0 && errno != EINTR) return system_error("cannot be waited for", path);
  if (ready <= 0) return std::size_t{0};
  const ssize_t n = ::read(fd, buffer.data(), buffer.size());
  if (n > 0) return static_cast<std::size_t>(n);
  if (n < 0 && (errno == EAGAIN || errno == EINTR)) return std::size_t{0};
  if (n == 0) return Error{ErrorCode::io, "the other side is gone", path};
  return system_error("cannot be read", path);
}

}  // namespace

Result<SerialPort> SerialPort::open(const std::string& path, const SerialOptions& options) {
  if (options.baud <= 0) return Error{ErrorCode::invalid, "needs a baud rate", path};
  Descriptor fd(::open(path.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC));
  if (fd.get() < 0 && errno == EBUSY) return in_use(path);
  if (fd.get() < 0) return system_error("cannot be opened", path);
  if (::isatty(fd.get()) != 0 && !lock(fd.get())) return in_use(path);
  SerialPort port(std::move(fd), path);
  if (!make_raw(port.descriptor(), options.baud, port.note_))
    return Error{ErrorCode::io, "is not a serial line", path};
  if (!port.set_dtr(options.dtr))
    port.note_ += std::string(port.note_.empty() ? "" : "; ") + "there is no modem line DTR";
  return port;
}

Result<std::size_t> SerialPort::read(std::span<std::uint8_t> buffer,
                                     std::chrono::milliseconds timeout) {
  return read_some(fd_.get(), buffer, timeout, path_);
}

Result<std::size_t> SerialPort::write(std::span<const std::uint8_t> bytes) {
  const ssize_t n = ::write(fd_.get(), bytes.data(), bytes.size());
  if (n >= 0) return static_cast<std::size_t>(n);
  if (errno == EAGAIN || errno == EINTR) return std::size_t{0};
  return system_error("cannot be written", path_);
}

bool SerialPort::set_dtr(ModemLine line) {
  const int bit = TIOCM_DTR;
  return line == ModemLine::keep ||
         ::ioctl(fd_.get(), line == ModemLine::on ? TIOCMBIS : TIOCMBIC, &bit) == 0;
}

std::size_t SerialPort::unsent() const {
  int waiting = 0;
  return ::ioctl(fd_.get(), TIOCOUTQ, &waiting) == 0 ? static_cast<std::size_t>(waiting) : 0;
}

std::optional<int> process_of_line(const std::string& path) {
  struct stat line {};
  if (::stat(path.c_str(), &line) != 0) return std::nullopt;
  // Of each lock: number, kind, "ADVISORY", "WRITE", process, MAJOR:MINOR:INODE of the file.
  std::ifstream locks("/proc/locks");
  for (std::string text; std::getline(locks, text);) {
    int process = 0;
    unsigned major_number = 0, minor_number = 0;
    unsigned long inode = 0;
    if (std::sscanf(text.c_str(), "%*s FLOCK %*s WRITE %d %x:%x:%lu", &process, &major_number,
                    &minor_number, &inode) == 4 &&
        process > 0 && inode == line.st_ino && major_number == major(line.st_dev) &&
        minor_number == minor(line.st_dev))
      return process;
  }
  return std::nullopt;
}

Result<PseudoTerminal> PseudoTerminal::open() {
  PseudoTerminal terminal;
  const int master = ::posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  terminal.master_ = Descriptor(master);
  char name[128];
  if (master < 0 || ::grantpt(master) != 0 || ::unlockpt(master) != 0 ||
      ::ptsname_r(master, name, sizeof name) != 0)
    return system_error("no pseudo-terminal", "");
  terminal.path_ = name;
  terminal.slave_ = Descriptor(::open(name, O_RDWR | O_NOCTTY | O_CLOEXEC));
  if (terminal.slave_.get() < 0) return system_error("cannot be opened", terminal.path_);
  std::string note;
  if (!make_raw(terminal.slave_.get(), 115200, note))
    return Error{ErrorCode::io, "is not a serial line", terminal.path_};
  return terminal;
}

Result<std::size_t> PseudoTerminal::write(std::span<const std::uint8_t> bytes,
                                          std::chrono::milliseconds timeout) {
  const auto until = std::chrono::steady_clock::now() + waitable(timeout);
  std::size_t done = 0;
  while (done < bytes.size()) {
    const ssize_t n = ::write(master_.get(), bytes.data() + done, bytes.size() - done);
    if (n > 0) {
      done += static_cast<std::size_t>(n);
      continue;
    }
    if (n < 0 && errno != EAGAIN && errno != EINTR) return system_error("cannot be written", path_);
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(
        until - std::chrono::steady_clock::now());
    if (left.count() <= 0) break;
    pollfd p{master_.get(), POLLOUT, 0};
    ::poll(&p, 1, static_cast<int>(left.count()));
  }
  return done;
}

Result<std::size_t> PseudoTerminal::read(std::span<std::uint8_t> buffer,
                                         std::chrono::milliseconds timeout) {
  return read_some(master_.get(), buffer, timeout, path_);
}

std::size_t PseudoTerminal::unread() const {
  int waiting = 0;
  return ::ioctl(slave_.get(), FIONREAD, &waiting) == 0 ? static_cast<std::size_t>(waiting) : 0;
}

std::vector<TimedBytes> at_rate(decode::Bytes bytes, double bytes_per_s, std::size_t piece) {
  WAYFARE_EXPECTS(bytes_per_s > 0.0 && piece > 0,
                  "bytes per second and bytes per piece must be positive");
  std::vector<TimedBytes> stream;
  for (std::size_t at = 0; at < bytes.size();) {
    const std::size_t n = std::min(piece, bytes.size() - at);
    stream.push_back(
        {from_seconds(static_cast<double>(at + n) / bytes_per_s), bytes.subspan(at, n)});
    at += n;
  }
  return stream;
}

Result<std::uint64_t> play(PseudoTerminal& terminal, const std::vector<TimedBytes>& stream,
                           double speed, const std::atomic<bool>& stop) {
  WAYFARE_EXPECTS(speed > 0.0, "the speed must be positive");
  using Clock = std::chrono::steady_clock;
  constexpr Duration kLongest = std::chrono::hours(24 * 365 * 100);
  const Clock::time_point begin = Clock::now();
  std::uint64_t written = 0;
  for (const TimedBytes& piece : stream) {
    const auto due = begin + std::min(from_seconds(to_seconds(piece.at) / speed), kLongest);
    while (!stop && Clock::now() < due)
      std::this_thread::sleep_until(std::min(due, Clock::now() + std::chrono::milliseconds(50)));
    decode::Bytes rest = piece.bytes;
    while (!rest.empty()) {
      if (stop) return written;
      const auto n = terminal.write(rest, std::chrono::milliseconds(50));
      if (!n) return n.error();
      written += *n;
      rest = rest.subspan(*n);
    }
  }
  return written;
}

}  // namespace wayfare::logger
