// Serial lines and simulated devices at their edges.
#include <atomic>
#include <chrono>
#include <cstdint>
#include <limits>
#include <span>
#include <thread>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include <wayfare/logger/device_decoder.hpp>
#include <wayfare/logger/serial_port.hpp>

#include "abuse/abuse.hpp"
#include "abuse/decode_streams.hpp"

namespace wayfare::logger {
namespace {

using namespace std::chrono_literals;
using tests::Stream;

TEST(SerialPortAbuse, RatesBuffersAndTimeouts) {
  auto terminal = PseudoTerminal::open();
  ASSERT_TRUE(terminal);
  for (const int baud : {0, -1, std::numeric_limits<int>::min()})
    EXPECT_FALSE(SerialPort::open(terminal->path(), {.baud = baud}));
  EXPECT_FALSE(SerialPort::open(""));
  EXPECT_FALSE(SerialPort::open("/"));
  EXPECT_FALSE(SerialPort::open("/dev/null"));
  auto port = SerialPort::open(terminal->path(), {.baud = std::numeric_limits<int>::max()});
  ASSERT_TRUE(port);
  std::vector<std::uint8_t> buffer(10);
  for (const auto timeout : {0ms, -1ms, std::chrono::milliseconds::min()}) {
    EXPECT_EQ(port->read(buffer, timeout).value(), 0U) << "does not wait";
    EXPECT_EQ(terminal->read(buffer, timeout).value(), 0U);
    EXPECT_EQ(terminal->write({}, timeout).value(), 0U);
  }
  EXPECT_EQ(port->write({}).value(), 0U);
  const Stream bytes = {1, 2, 3};
  ASSERT_EQ(terminal->write(bytes, std::chrono::milliseconds::max()).value(), 3U);
  EXPECT_EQ(port->read(std::span(buffer).first(0), 0ms).value(), 0U) << "the line is not closed";
  ASSERT_EQ(port->read(buffer, std::chrono::milliseconds::max()).value(), 3U);
  EXPECT_EQ(buffer[2], 3);
}

TEST(SerialPortAbuse, MovedLines) {
  auto terminal = PseudoTerminal::open();
  ASSERT_TRUE(terminal);
  auto first = SerialPort::open(terminal->path());
  ASSERT_TRUE(first);
  SerialPort second(std::move(*first));
  EXPECT_EQ(first->descriptor(), -1);
  std::vector<std::uint8_t> buffer(10);
  static_cast<void>(first->read(buffer, 1ms));
  static_cast<void>(first->write(buffer));
  *first = std::move(second);
  SerialPort& same = *first;
  *first = std::move(same);
  PseudoTerminal moved = std::move(*terminal);
  EXPECT_EQ(terminal->unread(), 0U);
  const Stream bytes = {5};
  ASSERT_EQ(moved.write(bytes, 1s).value(), 1U);
  EXPECT_EQ(first->read(buffer, 20s).value(), 1U);
  EXPECT_EQ(buffer[0], 5);
}

TEST(SerialPortAbuseDeathTest, StreamsHavePiecesAndRates) {
  const Stream bytes(10);
  EXPECT_DEATH(static_cast<void>(at_rate(bytes, 1.0, 0)), "must be positive");
  for (const double rate : {0.0, -1.0, tests::kNan})
    EXPECT_DEATH(static_cast<void>(at_rate(bytes, rate)), "must be positive");
  auto terminal = PseudoTerminal::open();
  const std::atomic<bool> stop{false};
  for (const double speed : {0.0, -1.0, tests::kNan})
    EXPECT_DEATH(static_cast<void>(play(*terminal, {}, speed, stop)), "speed must be positive");
}

TEST(SerialPortAbuse, StreamsOfAnyLength) {
  EXPECT_TRUE(at_rate({}, 1.0).empty());
  const Stream bytes(10);
  const auto one = at_rate(bytes, 1e-300, SIZE_MAX);
  ASSERT_EQ(one.size(), 1U);
  EXPECT_EQ(one[0].at, Duration::max());
  EXPECT_EQ(at_rate(bytes, tests::kInf, 3).size(), 4U);
  auto terminal = PseudoTerminal::open();
  std::atomic<bool> stop{false};
  EXPECT_EQ(play(*terminal, {}, 1.0, stop).value(), 0U);
  EXPECT_EQ(play(*terminal, at_rate(bytes, 1.0), tests::kInf, stop).value(), 10U);
  EXPECT_EQ(play(*terminal, {{Duration::min(), bytes}}, 1.0, stop).value(), 10U);
  // In a hundred years and later: until it is stopped.
  std::thread stopper([&] {
    std::this_thread::sleep_for(20ms);
    stop = true;
  });
  EXPECT_EQ(play(*terminal, one, 1e-3, stop).value(), 0U);
  stopper.join();
}

}  // namespace
}  // namespace wayfare::logger
