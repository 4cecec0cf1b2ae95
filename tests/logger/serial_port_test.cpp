// Serial lines, from both ends of a pseudo-terminal.
#include <wayfare/logger/serial_port.hpp>

#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <fstream>
#include <numeric>
#include <string>
#include <thread>
#include <vector>

#include <wayfare/logger/device_decoder.hpp>
#include "simulated_devices.hpp"

namespace wayfare::logger {
namespace {

using namespace std::chrono_literals;
using ::testing::HasSubstr;

std::vector<std::uint8_t> all_bytes(int times) {
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(256 * times));
  std::iota(bytes.begin(), bytes.end(), std::uint8_t{0});
  return bytes;
}

std::vector<std::uint8_t> read_up_to(SerialPort& port, std::size_t n) {
  std::vector<std::uint8_t> got;
  std::vector<std::uint8_t> buffer(4096);
  for (int idle = 0; got.size() < n && idle < 20;) {
    const auto read = port.read(buffer, 100ms);
    if (!read) break;
    idle = *read == 0 ? idle + 1 : 0;
    got.insert(got.end(), buffer.begin(), buffer.begin() + static_cast<std::ptrdiff_t>(*read));
  }
  return got;
}

TEST(SerialPort, PassesEveryByteValueBothWays) {
  auto terminal = PseudoTerminal::open();
  ASSERT_TRUE(terminal);
  auto port = SerialPort::open(terminal->path(), {.baud = 921600});
  ASSERT_TRUE(port);
  const auto bytes = all_bytes(4);
  ASSERT_EQ(terminal->write(bytes, 1s).value(), bytes.size());
  EXPECT_EQ(read_up_to(*port, bytes.size()), bytes);
  ASSERT_EQ(port->write(bytes).value(), bytes.size());
  std::vector<std::uint8_t> back, buffer(4096);
  while (back.size() < bytes.size()) {
    const auto n = terminal->read(buffer, 1s);
    ASSERT_TRUE(n && *n != 0);
    back.insert(back.end(), buffer.begin(), buffer.begin() + static_cast<std::ptrdiff_t>(*n));
  }
  EXPECT_EQ(back, bytes);
}

TEST(SerialPort, AcceptsUnusualRatesAndLinesWithoutDtr) {
  auto terminal = PseudoTerminal::open();
  ASSERT_TRUE(terminal);
  for (const int baud : {57600, 256000, 3000000}) {
    const auto port = SerialPort::open(terminal->path(), {.baud = baud});
    ASSERT_TRUE(port);
    EXPECT_EQ(port->note(), "") << baud;
  }
  const auto port = SerialPort::open(terminal->path(), {.dtr = ModemLine::off});
  ASSERT_TRUE(port);
  EXPECT_THAT(port->note(), HasSubstr("DTR"));
}

TEST(SerialPort, KeepsBytesReceivedBeforeOpening) {
  auto terminal = PseudoTerminal::open();
  const auto bytes = all_bytes(2);
  ASSERT_EQ(terminal->write(bytes, 1s).value(), bytes.size());
  EXPECT_TRUE(
      ::wayfare::testing::wait_for(20s, [&] { return terminal->unread() == bytes.size(); }));
  auto port = SerialPort::open(terminal->path());
  EXPECT_EQ(read_up_to(*port, bytes.size()), bytes);
  EXPECT_EQ(terminal->unread(), 0U);
}

TEST(SerialPort, ReportsInvalidAndClosedLines) {
  EXPECT_THAT(SerialPort::open("/nowhere/tty").error().to_string(), HasSubstr("cannot be opened"));
  const ::wayfare::testing::TemporaryFolder folder;
  std::ofstream(folder / "file") << "x";
  EXPECT_THAT(SerialPort::open(folder / "file").error().to_string(),
              HasSubstr("not a serial line"));
  auto terminal = PseudoTerminal::open();
  auto port = SerialPort::open(terminal->path());
  std::vector<std::uint8_t> buffer(10);
  EXPECT_EQ(port->read(buffer, 1ms).value(), 0U);
  { const PseudoTerminal gone = std::move(*terminal); }
  EXPECT_FALSE(port->read(buffer, 1s));
}

TEST(SerialPort, IsOfOneOnly) {
  auto terminal = PseudoTerminal::open();
  EXPECT_EQ(process_of_line(terminal->path()), std::nullopt);
  EXPECT_EQ(process_of_line("/nowhere/tty"), std::nullopt);
  {
    const auto first = SerialPort::open(terminal->path());
    ASSERT_TRUE(first);
    EXPECT_EQ(process_of_line(terminal->path()), ::getpid());
    const auto second = SerialPort::open(terminal->path());
    ASSERT_FALSE(second);
    EXPECT_THAT(second.error().to_string(),
                HasSubstr("in use by process " + std::to_string(::getpid())));
  }
  EXPECT_TRUE(SerialPort::open(terminal->path()));
}

TEST(SerialPort, OfAKilledProgramIsFree) {
  auto terminal = PseudoTerminal::open();
  const pid_t other = ::fork();
  if (other == 0) {
    [[maybe_unused]] const auto port = SerialPort::open(terminal->path());
    for (;;) ::pause();
  }
  ASSERT_GT(other, 0);
  EXPECT_TRUE(::wayfare::testing::wait_for(
      20s, [&] { return process_of_line(terminal->path()) == other; }));
  EXPECT_FALSE(SerialPort::open(terminal->path()));
  ::kill(other, SIGKILL);
  ::waitpid(other, nullptr, 0);
  EXPECT_TRUE(SerialPort::open(terminal->path()));
}

TEST(StreamPlayer, KeepsTheTimesAndTheBytes) {
  auto terminal = PseudoTerminal::open();
  auto port = SerialPort::open(terminal->path());
  const auto bytes = all_bytes(40);
  const auto stream = at_rate(bytes, 20000.0);
  ASSERT_EQ(stream.back().at, from_seconds(10240 / 20000.0));
  std::atomic<bool> stop{false};
  std::uint64_t played = 0;
  const auto begin = std::chrono::steady_clock::now();
  std::thread player([&] { played = play(*terminal, stream, 5.0, stop).value_or(0); });
  const auto got = read_up_to(*port, bytes.size());
  player.join();
  EXPECT_EQ(got, bytes);
  EXPECT_EQ(played, bytes.size());
  // Never faster than requested: half a second at five times the rate.
  EXPECT_GE(std::chrono::steady_clock::now() - begin, 102ms);
}

TEST(StreamPlayer, StopsWithoutAReader) {
  auto terminal = PseudoTerminal::open();
  const std::vector<std::uint8_t> bytes(1 << 20);
  std::atomic<bool> stop{false};
  std::uint64_t played = 0;
  std::thread player([&] { played = play(*terminal, at_rate(bytes, 1e9), 1.0, stop).value_or(0); });
  std::this_thread::sleep_for(100ms);
  stop = true;
  player.join();
  EXPECT_LT(played, bytes.size());
}

}  // namespace
}  // namespace wayfare::logger
