#include "logger/control_line.hpp"

#include <poll.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>
#include <zlib.h>

#include <array>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <string>
#include <utility>

#include <wayfare/logger/messages.hpp>

#include "logger/time_parts.hpp"

namespace wayfare::logger {

using io::system_error;

namespace {

constexpr std::size_t kMostClients = 16;

/// CRC-32 in eight hexadecimal digits.
std::string checksum(std::string_view bytes) {
  const auto sum =
      ::crc32(0, reinterpret_cast<const Bytef*>(bytes.data()), static_cast<uInt>(bytes.size()));
  std::array<char, 9> text{};
  std::snprintf(text.data(), text.size(), "%08x", static_cast<unsigned>(sum));
  return text.data();
}

/// One decimal, cut off. Independent of the locale, whose decimal point may be another.
std::string number(double value) {
  std::array<char, 400> text{};  // the longest has 309 digits before the point
  const char* end = std::to_chars(text.data(), text.data() + text.size(),
                                  std::isfinite(value) ? value : 0.0, std::chars_format::fixed, 6)
                        .ptr;
  return std::string(text.cbegin(), end - 5);
}

}  // namespace

Result<ControlLine> ControlLine::open(const std::string& port, int baud,
                                      const std::string& socket) {
  ControlLine line;
  line.port_path_ = port;
  line.baud_ = baud;
  if (!port.empty()) {
    auto opened = SerialPort::open(port, {baud, ModemLine::keep});
    if (!opened) return opened.error();
    line.port_.emplace(std::move(*opened));
  }
  if (!socket.empty())
    if (auto done = line.listen(socket); !done) return done.error();
  return line;
}

ControlLine::~ControlLine() {
  if (listener_.get() >= 0) ::unlink(socket_path_.c_str());
}

Result<void> ControlLine::listen(const std::string& path) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (path.size() >= sizeof address.sun_path)
    return Error{ErrorCode::invalid, "is too long for a socket's name", path};
  std::memcpy(address.sun_path, path.c_str(), path.size());
  const auto* name = reinterpret_cast<const sockaddr*>(&address);
  constexpr int kType = SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK;
  Descriptor socket(::socket(AF_UNIX, kType, 0));
  const Descriptor probe(::socket(AF_UNIX, kType, 0));
  if (socket.get() < 0 || probe.get() < 0) return system_error("no socket", path);
  // Remove the socket of a killed logger; keep one that is listened on, and all that is no socket.
  if (::connect(probe.get(), name, sizeof address) == 0 || errno == EAGAIN)
    return Error{ErrorCode::io, "is in use by another logger", path};
  struct stat there {};
  if (::lstat(path.c_str(), &there) == 0 && S_ISSOCK(there.st_mode)) ::unlink(path.c_str());
  // Only this user may control the logger: the file gets the mode of the socket.
  if (::fchmod(socket.get(), 0600) != 0 || ::bind(socket.get(), name, sizeof address) != 0 ||
      ::listen(socket.get(), 8) != 0)
    return system_error("cannot be listened on", path);
  listener_ = std::move(socket);
  socket_path_ = path;
  return {};
}

void ControlLine::accept() {
  Descriptor client(::accept4(listener_.get(), nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK));
  if (client.get() >= 0 && clients_.size() < kMostClients) clients_.push_back(std::move(client));
}

bool ControlLine::take(const Descriptor& client, const std::function<void(Command)>& sink) {
  std::array<std::uint8_t, 64> bytes;
  const ssize_t n = ::recv(client.get(), bytes.data(), bytes.size(), 0);
  if (n < 0) return errno == EAGAIN || errno == EINTR;
  for (std::size_t i = 0; i < static_cast<std::size_t>(n); ++i)
    if (const auto command = command_of(bytes[i])) sink(*command);
  return n != 0;
}

void ControlLine::poll(std::chrono::milliseconds timeout,
                       const std::function<void(Command)>& sink) {
  if (!port_ && !port_path_.empty()) {
    if (auto opened = SerialPort::open(port_path_, {baud_, ModemLine::keep}))
      port_.emplace(std::move(*opened));
  }
  // Clients first: those accepted below have not been polled.
  std::vector<pollfd> fds;
  for (const Descriptor& client : clients_) fds.push_back({client.get(), POLLIN, 0});
  fds.push_back({listener_.get(), POLLIN, 0});
  fds.push_back({port_ ? port_->descriptor() : -1, POLLIN, 0});
  if (::poll(fds.data(), fds.size(), static_cast<int>(timeout.count())) <= 0) return;
  std::vector<Descriptor> staying;
  for (std::size_t i = 0; i < clients_.size(); ++i)
    if (fds[i].revents == 0 || take(clients_[i], sink)) staying.push_back(std::move(clients_[i]));
  clients_ = std::move(staying);
  if (fds[fds.size() - 2].revents != 0) accept();
  if (fds.back().revents == 0) return;
  std::array<std::uint8_t, 64> bytes;
  const auto n = port_->read(bytes, std::chrono::milliseconds(0));
  if (!n) {
    port_.reset();
    return;
  }
  for (std::size_t i = 0; i < *n; ++i)
    if (const auto command = command_of(bytes[i])) sink(*command);
}

void ControlLine::send(std::string_view line) {
  if (port_) {
    const auto* bytes = reinterpret_cast<const std::uint8_t*>(line.data());
    if (!port_->write({bytes, line.size()})) port_.reset();
  }
  std::erase_if(clients_, [&](const Descriptor& client) {
    const ssize_t n = ::send(client.get(), line.data(), line.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
    return n != static_cast<ssize_t>(line.size());
  });
}

std::optional<Command> command_of(std::uint8_t byte) {
  for (const Command command : {Command::begin, Command::stop, Command::terminate, Command::check})
    if (byte == static_cast<std::uint8_t>(command)) return command;
  return std::nullopt;
}

std::string status_line(std::string_view json) {
  return std::string(json) + '*' + checksum(json) + '\n';
}

std::optional<std::string_view> status_of_line(std::string_view line) {
  while (!line.empty() && (line.back() == '\n' || line.back() == '\r')) line.remove_suffix(1);
  if (line.size() < 9 || line[line.size() - 9] != '*') return std::nullopt;
  const std::string_view json = line.substr(0, line.size() - 9);
  if (line.substr(line.size() - 8) != checksum(json)) return std::nullopt;
  return json;
}

const char* name_of(LoggerState state) {
  constexpr std::array kNames = {"idle",     "starting", "recording",
                                 "stopping", "failed",   "terminated"};
  return kNames[static_cast<std::size_t>(state)];
}

const char* name_of(SensorState state) {
  constexpr std::array kNames = {"waiting", "silent", "receiving"};
  return kNames[static_cast<std::size_t>(state)];
}

std::string to_json(const LoggerStatus& status) {
  const auto text = [](const std::string& s) { return '"' + json_escaped(s) + '"'; };
  const auto [sec, nsec] = seconds_and_rest(status.time);
  std::string out = "{\"state\":" + text(name_of(status.state));
  out +=
      ",\"timestamp\":{\"sec\":" + std::to_string(sec) + ",\"nsec\":" + std::to_string(nsec) + '}';
  out += ",\"file\":" + text(status.file) + ",\"seconds\":" + number(status.seconds);
  out += ",\"written\":" + std::to_string(status.written);
  out += ",\"disk_free\":" + std::to_string(status.disk_free);
  out += ",\"queued\":" + std::to_string(status.queued);
  out += ",\"queue_peak\":" + std::to_string(status.queue_peak);
  out += ",\"dropped\":" + std::to_string(status.dropped);
  out += ",\"error\":" + text(status.error) + ",\"sensors\":[";
  for (const SensorStatus& s : status.sensors) {
    if (&s != &status.sensors.front()) out += ',';
    out += "{\"name\":" + text(s.name) + ",\"state\":" + text(name_of(s.state));
    out += ",\"bytes\":" + std::to_string(s.bytes);
    out += ",\"recorded\":" + std::to_string(s.recorded_bytes);
    out += ",\"dropped\":" + std::to_string(s.dropped);
    out += ",\"bytes_per_s\":" + number(s.bytes_per_s);
    out += ",\"messages_per_s\":" + number(s.messages_per_s);
    out += ",\"messages\":" + std::to_string(s.decoding.messages);
    out += ",\"skipped_bytes\":" + std::to_string(s.decoding.skipped_bytes);
    out += ",\"damaged\":" + std::to_string(s.decoding.damaged);
    out += ",\"sample\":" + text(s.decoding.sample) + ",\"note\":" + text(s.note) + '}';
  }
  return out + "]}";
}

}  // namespace wayfare::logger
