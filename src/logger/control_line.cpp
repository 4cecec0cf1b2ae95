#include "logger/control_line.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sys/file.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <utility>

namespace wayfare::logger {

using io::system_error;

constexpr std::size_t kMostClients = 16;

namespace {

/// Of the program that listens at the other end of a socket.
std::string process_of(int socket) {
  ucred owner{};
  socklen_t length = sizeof owner;
  return ::getsockopt(socket, SOL_SOCKET, SO_PEERCRED, &owner, &length) == 0 && owner.pid > 0
             ? ", process " + std::to_string(owner.pid)
             : "";
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
  // Another program may have replaced it.
  struct stat there {};
  if (listener_.get() >= 0 && ::lstat(socket_path_.c_str(), &there) == 0 &&
      there.st_dev == device_ && there.st_ino == inode_)
    ::unlink(socket_path_.c_str());
}

Result<void> ControlLine::listen(const std::string& path) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (path.size() >= sizeof address.sun_path)
    return Error{ErrorCode::invalid, "is too long for a socket's name", path};
  std::memcpy(address.sun_path, path.c_str(), path.size());
  const auto* name = reinterpret_cast<const sockaddr*>(&address);
  constexpr int kType = SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK;
  // Others that look whether the socket is in use wait until it is.
  const auto folder = std::filesystem::path(path).parent_path();
  const Descriptor lock(
      ::open(folder.empty() ? "." : folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (lock.get() >= 0) ::flock(lock.get(), LOCK_EX);
  Descriptor socket(::socket(AF_UNIX, kType, 0));
  const Descriptor probe(::socket(AF_UNIX, kType, 0));
  if (socket.get() < 0 || probe.get() < 0) return system_error("no socket", path);
  // Remove the socket of a killed logger; keep one that is listened on, and all that is no socket.
  if (::connect(probe.get(), name, sizeof address) == 0 || errno == EAGAIN)
    return Error{ErrorCode::io, "is in use by another logger" + process_of(probe.get()), path};
  struct stat there {};
  if (::lstat(path.c_str(), &there) == 0 && S_ISSOCK(there.st_mode)) ::unlink(path.c_str());
  // Only this user may control the logger: the file gets the mode of the socket.
  if (::fchmod(socket.get(), 0600) != 0 || ::bind(socket.get(), name, sizeof address) != 0 ||
      ::listen(socket.get(), 8) != 0)
    return system_error("cannot be listened on", path);
  listener_ = std::move(socket);
  socket_path_ = path;
  if (::lstat(path.c_str(), &there) == 0) device_ = there.st_dev, inode_ = there.st_ino;
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
  // A slow line is still sending the last one: half a line would be of no use.
  if (port_ && port_->unsent() == 0) {
    const auto* bytes = reinterpret_cast<const std::uint8_t*>(line.data());
    if (!port_->write({bytes, line.size()})) port_.reset();
  }
  // What a client has sent before it closed, or was closed, is still obeyed: poll() removes it.
  for (const Descriptor& client : clients_) {
    const ssize_t n = ::send(client.get(), line.data(), line.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
    if (n != static_cast<ssize_t>(line.size())) ::shutdown(client.get(), SHUT_RDWR);
  }
}

}  // namespace wayfare::logger
