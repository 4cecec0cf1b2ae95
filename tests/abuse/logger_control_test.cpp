// Clients of a logger's control socket that stay silent, do not read, send what are no commands, or
// come by the thousand; two loggers at one socket; a control line that nobody reads.
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <iterator>
#include <string>
#include <string_view>
#include <thread>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include <wayfare/io/detail/descriptor.hpp>
#include <wayfare/logger/logger.hpp>

#include "abuse/abuse.hpp"
#include "abuse/logger_sinks.hpp"
#include "io/support.hpp"
#include "logger/control_line.hpp"

namespace wayfare::logger {
namespace {

using namespace std::chrono_literals;
using tests::Bench;
using tests::Disk;
using ::wayfare::testing::TemporaryFolder;
using ::wayfare::testing::wait_for;

/// A connection to a control socket; it does not block.
class Client {
 public:
  explicit Client(const std::string& path) : fd_(::socket(AF_UNIX, SOCK_STREAM, 0)) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    path.copy(address.sun_path, sizeof address.sun_path - 1);
    connected_ =
        ::connect(fd_.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
  }
  [[nodiscard]] bool connected() const { return connected_; }

  bool send(std::string_view bytes) {
    return wait_for(1min,
                    [&] {
                      const ssize_t n = ::send(fd_.get(), bytes.data(), bytes.size(),
                                               MSG_NOSIGNAL | MSG_DONTWAIT);
                      if (n < 0) return errno != EAGAIN;
                      bytes.remove_prefix(static_cast<std::size_t>(n));
                      return bytes.empty();
                    }) &&
           bytes.empty();
  }
  void half_close() { ::shutdown(fd_.get(), SHUT_WR); }

  /// Whether a whole status line of that state arrives.
  bool sees(std::string_view state) {
    const std::string part = "\"state\":\"" + std::string(state) + '"';
    bool seen = false;
    return wait_for(1min,
                    [&] {
                      const bool open = read();
                      for (std::size_t end; !seen && (end = text_.find('\n')) != text_.npos;
                           text_.erase(0, end + 1)) {
                        const auto status = status_of_line(std::string_view(text_).substr(0, end));
                        EXPECT_TRUE(status) << "a socket loses nothing";
                        seen = status && status->find(part) != status->npos;
                      }
                      return seen || !open;
                    }) &&
           seen;
  }
  /// Whether the logger closes the connection, once everything is read.
  bool is_closed() {
    return wait_for(1min, [&] { return !read(); });
  }

 private:
  /// False at the end.
  bool read() {
    std::array<char, 4096> bytes;
    ssize_t n = 0;
    while ((n = ::recv(fd_.get(), bytes.data(), bytes.size(), MSG_DONTWAIT)) > 0)
      text_.append(bytes.data(), static_cast<std::size_t>(n));
    return n < 0 && (errno == EAGAIN || errno == EINTR);
  }

  io::Descriptor fd_;
  bool connected_ = false;
  std::string text_;
};

class LoggerControl : public ::testing::Test {
 protected:
  void SetUp() override {
    bench_.options.control_socket = socket_;
    bench_.options.status_every = 50ms;
    bench_.start();
  }
  [[nodiscard]] bool obeys(Client& client) {
    return client.send("B") && client.sees("recording") && client.send("S") && client.sees("idle");
  }

  TemporaryFolder folder_;
  const std::string socket_ = folder_ / "control";
  Disk disk_;
  Bench bench_{disk_};
};

std::ptrdiff_t open_files() {
  return std::distance(std::filesystem::directory_iterator("/proc/self/fd"), {});
}

TEST_F(LoggerControl, ThousandsOfConnectionsLeaveNothingBehind) {
  Client first(socket_);
  ASSERT_TRUE(obeys(first));
  const auto before = open_files();
  for (int i = 0; i < 2000; ++i) {
    Client other(socket_);
    ASSERT_TRUE(other.connected());
    if (i % 3 == 0) static_cast<void>(other.send("C"));  // it may be closed already
    if (i % 5 == 0) other.half_close();
    if (i % 500 != 499) continue;
    ASSERT_TRUE(obeys(first)) << i;
  }
  EXPECT_TRUE(wait_for(1min, [&] { return open_files() == before; }));
}

TEST_F(LoggerControl, SixteenSilentClientsAndOneMore) {
  {
    std::vector<Client> silent;
    for (int i = 0; i < 16; ++i) silent.emplace_back(socket_);
    ASSERT_TRUE(obeys(silent.back())) << "all are accepted";
    Client more(socket_);
    EXPECT_TRUE(more.is_closed()) << "not left waiting";
    EXPECT_TRUE(obeys(silent.front()));
  }
  EXPECT_TRUE(wait_for(1min, [&] {
    Client next(socket_);
    return next.send("C") && next.sees("idle");
  }));
}

TEST_F(LoggerControl, BytesThatAreNoCommands) {
  Client client(socket_);
  std::string noise(1 << 20, '\0');
  for (std::size_t i = 0; i < noise.size(); ++i) noise[i] = static_cast<char>(i % 251);
  std::erase_if(noise, [](char c) { return command_of(static_cast<std::uint8_t>(c)).has_value(); });
  ASSERT_TRUE(client.send(noise));
  EXPECT_TRUE(obeys(client)) << "the commands behind them";
  EXPECT_EQ(disk_.files().size(), 1U);
}

TEST_F(LoggerControl, AFloodOfCommandsDoesNotCloseTheOthers) {
  Client good(socket_), flood(socket_);
  ASSERT_TRUE(obeys(good));
  const std::string commands(640'000, 'C');
  EXPECT_TRUE(flood.send(commands));
  EXPECT_TRUE(obeys(good)) << "although it has not read meanwhile";
}

TEST_F(LoggerControl, AClientThatDoesNotReadIsClosed) {
  Bench busy(disk_);
  busy.options.control_socket = folder_ / "busy";
  busy.options.status_every = 1ms;
  busy.start();
  Client deaf(busy.options.control_socket);
  EXPECT_TRUE(wait_for(1min, [&] { return !deaf.send("C"); }));
  Client good(busy.options.control_socket);
  EXPECT_TRUE(good.send("B") && good.sees("recording"));
}

TEST_F(LoggerControl, AHalfClosedClientHasItsAnswer) {
  Client client(socket_);
  ASSERT_TRUE(client.send("B"));
  client.half_close();
  EXPECT_TRUE(client.sees("recording"));
  EXPECT_TRUE(client.is_closed());
}

TEST_F(LoggerControl, TwoLoggersAtOneSocket) {
  Bench second(disk_);
  second.options.status_every = 50ms;
  second.options.control_socket = socket_;
  const auto refused = Logger::start(second.options);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().source, socket_);
  Client client(socket_);
  EXPECT_TRUE(obeys(client)) << "the first is still in control of it";
  bench_.logger.reset();
  EXPECT_FALSE(std::filesystem::exists(socket_));
  second.start();
  Client other(socket_);
  EXPECT_TRUE(obeys(other));
}

TEST_F(LoggerControl, WhatAKilledLoggerLeftIsReplacedAndNothingElse) {
  const std::string left = folder_ / "left", file = folder_ / "file";
  {
    const io::Descriptor killed(::socket(AF_UNIX, SOCK_STREAM, 0));
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    left.copy(address.sun_path, sizeof address.sun_path - 1);
    ASSERT_EQ(::bind(killed.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  }
  Bench second(disk_);
  second.options.status_every = 50ms;
  second.options.control_socket = left;
  second.start();
  Client client(left);
  EXPECT_TRUE(obeys(client));
  ASSERT_TRUE(io::write_file(file, "notes"));
  bench_.options.control_socket = file;
  EXPECT_FALSE(Logger::start(bench_.options));
  EXPECT_TRUE(std::filesystem::is_regular_file(file));
}

/// The mask of a process belongs to all its threads.
TEST(LoggerControlMask, SocketsOfTheirOwnerAndAnUnchangedMask) {
  const mode_t before = ::umask(0);
  const TemporaryFolder folder;
  static_cast<void>(tests::in_two_threads([&](int instance) {
    for (int i = 0; i < 10; ++i) {
      Disk disk;
      Bench bench(disk);
      bench.options.sensors[0].port = "/nowhere";
      bench.options.control_socket = folder / std::to_string(instance);
      bench.start();
      struct stat there {};
      EXPECT_EQ(::stat(bench.options.control_socket.c_str(), &there), 0);
      EXPECT_EQ(there.st_mode & 0777U, 0600U);
    }
    return 0;
  }));
  EXPECT_EQ(::umask(before), 0U);
}

/// A control line without a logger.
class ControlSocket : public ::testing::Test {
 protected:
  void SetUp() override { ASSERT_TRUE(line_); }
  void poll() {
    line_->poll(0ms, [&](Command c) { commands_.push_back(c); });
  }

  TemporaryFolder folder_;
  Result<ControlLine> line_ = ControlLine::open("", 0, folder_ / "control");
  std::vector<Command> commands_;
};

TEST_F(ControlSocket, TheLastCommandOfAClientThatHasGoneIsObeyed) {
  {
    Client client(folder_ / "control");
    poll();
    ASSERT_TRUE(client.send("S"));
  }
  line_->send("a status\n");
  for (int i = 0; i < 3; ++i) poll();
  EXPECT_EQ(commands_, std::vector{Command::stop});
}

TEST_F(ControlSocket, AClientThatDoesNotReadIsClosedAndItsCommandsObeyed) {
  Client deaf(folder_ / "control");
  poll();
  ASSERT_TRUE(deaf.send("B"));
  const std::string status(100'000, 'x');  // some fill what the system keeps of a socket
  for (int i = 0; i < 100; ++i) line_->send(status);
  for (int i = 0; i < 3; ++i) poll();
  EXPECT_EQ(commands_, std::vector{Command::begin});
  EXPECT_FALSE(deaf.send("S"));
}

TEST(LoggerControlLine, NobodyReads) {
  Disk disk;
  Bench bench(disk);
  auto line = PseudoTerminal::open();
  ASSERT_TRUE(line);
  bench.options.control_port = line->path();
  bench.options.status_every = 1ms;
  bench.start();
  ASSERT_TRUE(bench.logger->begin());
  for (int i = 0; i < 200; ++i) bench.send();
  // The line is full; the commands are obeyed, and what is read at last has whole lines again.
  const std::uint8_t stop = 'S';
  ASSERT_EQ(line->write({&stop, 1}, 20s).value_or(0), 1U);
  ASSERT_TRUE(bench.logger->wait_until_stopped(20s));
  EXPECT_EQ(tests::numbers_in(disk.files().at(0)->bytes).size(), 200U);
  std::string text;
  EXPECT_TRUE(wait_for(1min, [&] {
    std::array<std::uint8_t, 4096> bytes;
    const auto n = line->read(bytes, 1ms);
    if (n) text.append(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(*n));
    for (std::size_t end; (end = text.find('\n')) != text.npos; text.erase(0, end + 1)) {
      const auto status = status_of_line(std::string_view(text).substr(0, end));
      if (status && status->find("\"state\":\"idle\"") != status->npos) return true;
    }
    return false;
  }));
}

}  // namespace
}  // namespace wayfare::logger
