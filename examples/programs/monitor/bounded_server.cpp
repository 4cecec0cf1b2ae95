#include "bounded_server.hpp"

#include <netdb.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <functional>
#include <utility>

#include "access.hpp"

namespace wayfare::examples {
namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

/// Whether the socket is ready before `until`.
bool wait(int socket, short what, Clock::time_point until) {
  for (;;) {
    const auto left = std::chrono::ceil<milliseconds>(until - Clock::now());
    pollfd p{socket, what, 0};
    const int ready = ::poll(&p, 1, static_cast<int>(std::max<long>(left.count(), 0)));
    if (ready >= 0 || errno != EINTR) return ready > 0;
  }
}

using NameOf = int (*)(int, sockaddr*, socklen_t*);

/// The numeric address and port of one end.
void end_of(int socket, NameOf name_of, std::string& address, int& port) {
  sockaddr_storage storage{};
  socklen_t length = sizeof storage;
  auto* const name = reinterpret_cast<sockaddr*>(&storage);
  std::array<char, NI_MAXHOST> host{};
  std::array<char, NI_MAXSERV> service{};
  if (name_of(socket, name, &length) != 0 ||
      ::getnameinfo(name, length, host.data(), host.size(), service.data(), service.size(),
                    NI_NUMERICHOST | NI_NUMERICSERV) != 0)
    return;
  address = host.data();
  port = std::atoi(service.data());
}

/// A connection that reads a limited number of bytes until a deadline, for each request.
class BoundedStream : public httplib::Stream {
 public:
  BoundedStream(int socket, milliseconds write_time) : socket_(socket), write_time_(write_time) {}

  void begin_request(std::size_t bytes, milliseconds time) {
    left_ = bytes;
    begun_ = refused_ = false;
    until_ = Clock::now() + time;
  }
  /// Whether bytes arrive within `time`.
  [[nodiscard]] bool arrives(milliseconds time) const {
    return begin_ < end_ || wait(socket_, POLLIN, Clock::now() + time);
  }

  /// Whether the response to the request has no status of success: what follows in the connection
  /// may be the rest of that request.
  [[nodiscard]] bool refused() const { return refused_; }

  [[nodiscard]] bool is_readable() const override {
    return left_ > 0 && (begin_ < end_ || wait(socket_, POLLIN, until_));
  }
  [[nodiscard]] bool is_writable() const override {
    return wait(socket_, POLLOUT, Clock::now() + write_time_);
  }
  ssize_t read(char* to, std::size_t size) override {
    if (begin_ == end_ && !fill()) return -1;
    const std::size_t n = std::min({size, end_ - begin_, left_});
    if (n == 0) return left_ == 0 ? -1 : 0;
    std::memcpy(to, buffer_.data() + begin_, n);
    begin_ += n, left_ -= n;
    return static_cast<ssize_t>(n);
  }
  ssize_t write(const char* from, std::size_t size) override {
    constexpr std::size_t kStatus = 9;  // after "HTTP/1.1 "
    if (!std::exchange(begun_, true)) refused_ = size <= kStatus || from[kStatus] != '2';
    // The deadline holds for each part: a send that waits has none.
    while (is_writable()) {
      const ssize_t n = ::send(socket_, from, size, MSG_NOSIGNAL | MSG_DONTWAIT);
      if (n >= 0 || (errno != EAGAIN && errno != EINTR)) return n;
    }
    return -1;
  }
  void get_remote_ip_and_port(std::string& address, int& port) const override {
    end_of(socket_, ::getpeername, address, port);
  }
  void get_local_ip_and_port(std::string& address, int& port) const override {
    end_of(socket_, ::getsockname, address, port);
  }
  [[nodiscard]] socket_t socket() const override { return socket_; }

 private:
  /// False after the limit, the deadline or an error; nothing is in the buffer at the end.
  bool fill() {
    if (!is_readable()) return false;
    const ssize_t n = ::recv(socket_, buffer_.data(), buffer_.size(), 0);
    begin_ = 0;
    end_ = n > 0 ? static_cast<std::size_t>(n) : 0;
    return n >= 0;
  }

  const int socket_;
  const milliseconds write_time_;
  std::array<char, 4096> buffer_{};
  std::size_t begin_ = 0, end_ = 0, left_ = 0;
  bool begun_ = false, refused_ = false;  // of the response
  Clock::time_point until_;
};

}  // namespace

/// One of the places of an address; false if all are taken.
class BoundedServer::Place {
 public:
  Place(BoundedServer& server, const std::string& address) : server_(server), address_(address) {
    ++server_.taken_;
    if (is_loopback(address_)) return;
    const std::lock_guard lock(server_.mutex_);
    has_ = server_.by_address_[address_]++ < server_.limits_.per_address;
  }
  Place(const Place&) = delete;
  Place& operator=(const Place&) = delete;
  ~Place() {
    --server_.taken_;
    if (is_loopback(address_)) return;
    const std::lock_guard lock(server_.mutex_);
    const auto found = server_.by_address_.find(address_);
    if (--found->second == 0) server_.by_address_.erase(found);
  }
  explicit operator bool() const { return has_; }

 private:
  BoundedServer& server_;
  const std::string address_;
  bool has_ = true;
};

BoundedServer::BoundedServer(const ConnectionLimits& limits) : limits_(limits) {
  new_task_queue = [n = limits.connections] { return new httplib::ThreadPool(n); };
}

void BoundedServer::set_backlog(int connections) { ::listen(svr_sock_, connections); }

milliseconds BoundedServer::time() const {
  return 2 * taken_ > limits_.connections ? limits_.crowded_time : limits_.request_time;
}

bool BoundedServer::process_and_close_socket(socket_t socket) {
  std::string address;
  int port = 0;
  end_of(socket, ::getpeername, address, port);
  const int buffer = limits_.send_bytes;
  ::setsockopt(socket, SOL_SOCKET, SO_SNDBUF, &buffer, sizeof buffer);
  bool done = false;
  if (const Place place(*this, address); place) {
    BoundedStream stream(socket, limits_.write_time);
    std::size_t left = keep_alive_max_count_;
    for (bool open = true; open && left > 0 && svr_sock_ >= 0 && stream.arrives(time()); --left) {
      stream.begin_request(limits_.request_bytes, time());
      bool closed = false;
      done = process_request(stream, left == 1, closed, nullptr);
      open = done && !closed && !stream.refused();
    }
  }
  ::shutdown(socket, SHUT_RDWR);
  ::close(socket);
  return done;
}

}  // namespace wayfare::examples
