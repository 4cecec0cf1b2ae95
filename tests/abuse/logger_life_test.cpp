// The life of a logger at its edges: options, timeouts, commands from within its sinks, two at
// once.
#include <array>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <limits>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include <wayfare/logger/logger.hpp>

#include "abuse/abuse.hpp"
#include "abuse/logger_sinks.hpp"

namespace wayfare::logger {
namespace {

using namespace std::chrono_literals;
using tests::Bench;
using tests::Disk;
using tests::numbers_in;
using ::wayfare::testing::wait_for;

constexpr Duration kEver = Duration::max();

TEST(LoggerAbuse, OptionsThatCannotBeMet) {
  Disk disk;
  const Bench bench(disk);
  const auto refused = [&](const auto& change) {
    LoggerOptions options = bench.options;
    change(options);
    return !Logger::start(options);
  };
  EXPECT_TRUE(refused([](auto& o) { o.sensors.clear(); }));
  EXPECT_TRUE(refused([](auto& o) { o.sensors[0].device.name = ""; }));
  EXPECT_TRUE(refused([](auto& o) { o.sensors[0].device.name = "logger"; }));
  EXPECT_TRUE(refused([](auto& o) { o.sensors[0].device.baud = 0; }));
  EXPECT_TRUE(refused([](auto& o) { o.sensors[0].device.kind = ""; }));
  for (const Duration d : {Duration(0), Duration(-1), Duration(999'999), Duration::min()}) {
    EXPECT_TRUE(refused([&](auto& o) { o.flush_every = d; }));
    EXPECT_TRUE(refused([&](auto& o) { o.status_every = d; }));
  }
  EXPECT_TRUE(refused([](auto& o) { o.sync_every = Duration::min(); }));
  EXPECT_TRUE(refused([](auto& o) { o.control_port = "/dev/null"; }));
  EXPECT_TRUE(refused([](auto& o) { o.control_socket = std::string(10'000, 'x'); }));
  EXPECT_TRUE(refused([](auto& o) { o.control_socket = "/nowhere/socket"; }));
  EXPECT_FALSE(refused([](auto&) {}));
}

TEST(LoggerAbuse, IntervalsAndTimeoutsOfAnyLength) {
  Disk disk;
  Bench bench(disk);
  bench.options.flush_every = bench.options.sync_every = bench.options.status_every = kEver;
  bench.options.queue_bytes = SIZE_MAX;
  bench.start();
  EXPECT_TRUE(bench.logger->wait_until_stopped(Duration::min())) << "there is no recording";
  ASSERT_TRUE(bench.logger->begin());
  for (const Duration d : {Duration(0), Duration(-1), Duration::min()})
    EXPECT_FALSE(bench.logger->wait_until_stopped(d)) << "does not wait";
  for (int i = 0; i < 10; ++i) bench.send();
  std::thread stopper([&] {
    std::this_thread::sleep_for(20ms);
    bench.logger->stop();
  });
  EXPECT_TRUE(bench.logger->wait_until_stopped(kEver)) << "waits until it has stopped";
  stopper.join();
  EXPECT_EQ(bench.logger->status().state, LoggerState::idle);
  EXPECT_EQ(numbers_in(disk.files().at(0)->bytes).size(), 10U);
}

TEST(LoggerAbuse, AQueueWithoutRoomDropsAndCountsAll) {
  Disk disk;
  Bench bench(disk);
  bench.options.queue_bytes = 0;
  bench.start();
  ASSERT_TRUE(bench.logger->begin());
  for (int i = 0; i < 20; ++i) bench.send();
  bench.logger->stop();
  ASSERT_TRUE(bench.logger->wait_until_stopped(20s));
  const LoggerStatus status = bench.logger->status();
  EXPECT_EQ(status.state, LoggerState::idle);
  EXPECT_EQ(status.dropped, 20U);
  EXPECT_EQ(status.sensors[0].recorded_bytes, 0U);
  EXPECT_TRUE(numbers_in(disk.files().at(0)->bytes).empty());
}

TEST(LoggerAbuse, CommandsMayBeRepeated) {
  Disk disk;
  Bench bench(disk);
  bench.start();
  for (int i = 0; i < 3; ++i) bench.logger->stop();
  EXPECT_EQ(bench.logger->status().state, LoggerState::idle);
  for (int i = 0; i < 3; ++i) EXPECT_TRUE(bench.logger->begin());
  EXPECT_EQ(disk.files().size(), 1U);
  for (int i = 0; i < 3; ++i) bench.logger->stop();
  ASSERT_TRUE(bench.logger->wait_until_stopped(20s));
  for (int i = 0; i < 3; ++i) bench.logger->terminate();
  bench.logger->stop();
  EXPECT_EQ(bench.logger->status().state, LoggerState::terminated);
  for (int i = 0; i < 3; ++i) EXPECT_EQ(bench.logger->begin().error().code, ErrorCode::cancelled);
  EXPECT_EQ(disk.files().size(), 1U);
  EXPECT_TRUE(bench.logger->wait_until_stopped(0s));
}

TEST(LoggerAbuse, ASinkMayAskAndStop) {
  Disk disk;
  Bench bench(disk);
  std::atomic<int> asked{0};
  disk.on_write = [&] {
    if (bench.logger == nullptr) return;
    static_cast<void>(bench.logger->status());
    EXPECT_FALSE(bench.logger->wait_until_stopped(0s)) << "it is writing";
    if (++asked == 5) bench.logger->stop();
  };
  bench.start();
  ASSERT_TRUE(bench.logger->begin());
  // One write may take several pieces: how many it takes for five is up to the scheduler.
  ASSERT_TRUE(wait_for(1min, [&] {
    if (asked < 5) bench.send();
    return asked >= 5;
  }));
  ASSERT_TRUE(bench.logger->wait_until_stopped(20s));
  EXPECT_EQ(bench.logger->status().state, LoggerState::idle);
  bench.logger.reset();
}

TEST(LoggerAbuse, ACreationThatTerminates) {
  Disk disk;
  Bench bench(disk);
  auto open = disk.opener();
  bench.options.open_sink = [&](const std::string& path) {
    EXPECT_EQ(bench.logger->status().state, LoggerState::starting);
    bench.logger->terminate();
    return open(path);
  };
  bench.start();
  EXPECT_TRUE(bench.logger->begin());
  ASSERT_TRUE(bench.logger->wait_until_stopped(20s));
  EXPECT_EQ(bench.logger->status().state, LoggerState::terminated);
}

/// Each write in turn is the first that fails; and each flush to the disk.
TEST(LoggerAbuse, AFailureAtAnyPointIsCounted) {
  for (const bool half : {false, true})
    for (const bool sync : {false, true})
      for (std::int64_t n = 0; n < 12; ++n) {
        SCOPED_TRACE(std::to_string(n) + (sync ? " syncs" : " writes") + (half ? ", half" : ""));
        Disk disk;
        disk.half = half;
        (sync ? disk.syncs : disk.writes) = n;
        Bench bench(disk);
        bench.options.sync_every = Duration(0);
        bench.start();
        const bool begun = bench.logger->begin().has_value();
        EXPECT_EQ(begun, sync || n >= 2) << "a header and the metadata";
        std::uint32_t within = 0;
        for (int i = 0; i < 12; ++i) {
          bench.send();
          within += bench.logger->status().state == LoggerState::recording ? 1U : 0U;
        }
        bench.logger->stop();
        ASSERT_TRUE(bench.logger->wait_until_stopped(20s));
        const LoggerStatus status = bench.logger->status();
        const auto file = disk.files().at(0);
        const auto there = numbers_in(file->bytes);
        EXPECT_EQ(status.sensors[0].recorded_bytes, 8 * there.size());
        for (std::uint32_t i = 0; i < there.size(); ++i) EXPECT_EQ(there[i], i);
        if (!begun) {
          EXPECT_EQ(status.dropped, 0U);
          continue;
        }
        // The piece during which it failed may belong to the recording.
        EXPECT_GE(there.size() + status.dropped, within);
        EXPECT_LE(there.size() + status.dropped, within + 1);
        if (!half) {
          EXPECT_EQ(status.written, file->bytes.size());
        }
        disk.repair();
        EXPECT_TRUE(bench.logger->begin()) << "the next one works";
        EXPECT_EQ(bench.logger->status().error, "");
        EXPECT_EQ(bench.logger->status().dropped, 0U);
      }
}

/// A chunk is written when it is full, long before a flush is due.
TEST(LoggerAbuse, TheRecordThatFillsAChunkIsCounted) {
  Disk disk;
  Bench bench(disk);
  std::atomic<bool> stuck{false}, waiting{false};
  disk.on_write = [&] {
    for (waiting = stuck.load(); stuck;) std::this_thread::sleep_for(1ms);
  };
  bench.options.flush_every = kEver;
  bench.start();
  ASSERT_TRUE(bench.logger->begin());
  disk.writes = 0;
  stuck = true;
  const std::vector<std::uint8_t> piece(1000);
  std::uint64_t sent = 0;
  for (int more = 0; more < 5; more += waiting ? 1 : 0) {
    ++sent;
    ASSERT_EQ(bench.terminal.write(piece, 20s).value_or(0), piece.size());
    ASSERT_TRUE(bench.wait_for([&](const auto& s) { return s.bytes == sent * piece.size(); }));
  }
  stuck = false;
  ASSERT_TRUE(wait_for(1min, [&] { return bench.logger->status().state == LoggerState::failed; }));
  const LoggerStatus status = bench.logger->status();
  EXPECT_GT(sent, 1000U) << "a chunk is of a megabyte";
  EXPECT_GE(status.dropped, sent);
  EXPECT_EQ(status.sensors[0].recorded_bytes, 0U);
  EXPECT_EQ(status.written, disk.files().at(0)->bytes.size());
}

TEST(LoggerAbuse, TwoLoggersInTwoThreads) {
  const auto both = tests::in_two_threads([](int) {
    Disk disk;
    disk.delay_us = 200;
    std::vector<std::vector<std::uint32_t>> all;
    Bench bench(disk);
    bench.start();
    for (int k = 0; k < 3; ++k) {
      EXPECT_TRUE(bench.logger->begin());
      for (int i = 0; i < 20; ++i) bench.send();
      bench.logger->stop();
      EXPECT_TRUE(bench.logger->wait_until_stopped(20s));
    }
    bench.logger.reset();
    for (const auto& file : disk.files()) all.push_back(numbers_in(file->bytes));
    return all;
  });
  ASSERT_EQ(both[0].size(), 3U);
  EXPECT_EQ(both[0], both[1]);
  for (const auto& numbers : both[0]) EXPECT_EQ(numbers.size(), 20U);
}

TEST(LoggerAbuse, DestroyedInEveryState) {
  for (int state = 0; state < 6; ++state) {
    Disk disk;
    disk.delay_us = 2000;
    Bench bench(disk);
    bench.start();
    if (state == 1) disk.writes = 0;
    if (state != 0) static_cast<void>(bench.logger->begin());
    if (state >= 2) bench.send();
    if (state == 3) bench.logger->stop();
    if (state == 4) bench.logger->terminate();
    if (state == 5) disk.writes = 0;
    bench.logger.reset();
    if (state < 2 || state == 5) continue;
    EXPECT_EQ(numbers_in(disk.files().at(0)->bytes), std::vector<std::uint32_t>{0}) << state;
  }
}

}  // namespace
}  // namespace wayfare::logger
