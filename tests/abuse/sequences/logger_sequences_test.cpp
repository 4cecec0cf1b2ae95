// Random sequences of commands and of faults of the disk, with numbered records: each record that
// was read during a recording is in its file or counted as dropped, in order, and none twice; what
// the status says of it is what a reader of the file finds. And decoders of devices in random
// chunks.
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include <wayfare/core/random.hpp>
#include <wayfare/logger/device_decoder.hpp>
#include <wayfare/logger/logger.hpp>

#include "abuse/decode_streams.hpp"
#include "abuse/logger_sinks.hpp"

namespace wayfare::logger {
namespace {

using namespace std::chrono_literals;
using tests::Bench;
using tests::Disk;
using tests::numbers_in;

/// What a recording must contain, from the calls alone.
struct Model {
  bool active = false;  ///< a recording was begun and not stopped
  bool faulty = false;  ///< its disk has failed or may fail
  bool terminated = false;
  std::uint32_t begin = 0;  ///< number of the first record
  std::uint32_t least = 0;  ///< records read until the disk failed, or one fewer
};

struct LoggerTotal {
  std::uint64_t files = 0, recorded = 0, dropped = 0, failed = 0;
};

class LoggerSequence {
 public:
  LoggerSequence(std::uint64_t seed, LoggerTotal& total)
      : rng_(seed), total_(total), seed_(seed), bench_(disk_) {
    bench_.options.sync_every = rng_.below(2) == 0 ? Duration(0) : Duration(1s);
    bench_.options.flush_every = std::chrono::milliseconds(1 + rng_.below(3));
    narrow_ = rng_.below(3) == 0;
    if (narrow_) bench_.options.queue_bytes = 700;  // two or three records
    disk_.half = rng_.below(2) == 0;
  }

  void run() {
    bench_.start();
    for (int i = 0; i < 25 && !::testing::Test::HasFatalFailure(); ++i) step();
    SCOPED_TRACE(trace());
    if (rng_.below(3) == 0) {
      finish();
      return;
    }
    // Destroyed in the middle: what the disk takes is in the file.
    bench_.logger.reset();
    if (!model_.active || model_.faulty || narrow_) return;
    EXPECT_EQ(numbers_in(disk_.files().back()->bytes).size(), bench_.next - model_.begin);
  }

 private:
  [[nodiscard]] std::string trace() const { return "seed " + std::to_string(seed_) + ":" + calls_; }

  void step() {
    SCOPED_TRACE(trace());
    switch (rng_.below(10)) {
      case 0:
        return begin();
      case 1:
        return finish();
      case 2:
        if (rng_.below(15) != 0) return fault();
        calls_ += " terminate";
        bench_.logger->terminate();
        model_.terminated = true;
        return ended();
      case 3:
        disk_.delay_us = static_cast<int>(rng_.below(1500));
        return;
      case 4:
        if (model_.active) return;
        return begin();
      default:
        send();
    }
  }

  void begin() {
    calls_ += " begin";
    // Beginning again forgets the counts of a recording that has failed.
    if (model_.active && bench_.logger->status().state != LoggerState::recording) ended();
    const std::size_t files = disk_.files().size();
    const auto begun = bench_.logger->begin();
    const LoggerStatus status = bench_.logger->status();
    if (model_.terminated) {
      EXPECT_EQ(begun.error().code, ErrorCode::cancelled);
      return;
    }
    EXPECT_TRUE(begun || model_.faulty);
    if (begun && disk_.files().size() == files) {
      EXPECT_TRUE(model_.active) << "does nothing while one is being made";
      return;
    }
    // Another one, because that before has failed since.
    EXPECT_TRUE(!model_.active || model_.faulty);
    model_.active = begun.has_value();
    model_.begin = bench_.next;
    model_.least = 0;
    if (begun) return;
    EXPECT_EQ(status.state, LoggerState::failed);
    EXPECT_EQ(status.error, begun.error().to_string());
    EXPECT_EQ(status.written + status.dropped + status.sensors[0].recorded_bytes, 0U);
  }

  void send() {
    calls_ += " send";
    bench_.send();
    if (bench_.logger->status().state == LoggerState::recording)
      model_.least = bench_.next - model_.begin;
  }

  /// The disk fails after some more writes, or is repaired.
  void fault() {
    const auto kind = rng_.below(4);
    const auto after = static_cast<std::int64_t>(rng_.below(4));
    calls_ += " fault" + std::to_string(kind) + "-" + std::to_string(after);
    if (kind == 0) disk_.writes = after;
    if (kind == 1) disk_.syncs = after;
    if (kind == 2) disk_.creations = 0;
    if (kind == 3) disk_.repair();
    if (kind != 3) model_.faulty = true;
    if (kind == 3 && !model_.active) model_.faulty = false;
  }

  void finish() {
    calls_ += " stop";
    bench_.logger->stop();
    ended();
  }

  /// Waits until the recording has ended and checks all that is said of it.
  void ended() {
    ASSERT_TRUE(bench_.logger->wait_until_stopped(20s));
    const LoggerStatus status = bench_.logger->status();
    if (model_.terminated) {
      EXPECT_EQ(status.state, LoggerState::terminated);
    }
    if (!std::exchange(model_.active, false)) return;
    ++total_.files;
    const auto file = disk_.files().back();
    const std::vector<std::uint32_t> there = numbers_in(file->bytes);
    const std::uint64_t read = bench_.next - model_.begin;
    EXPECT_EQ(status.file, file->path);
    EXPECT_EQ(status.sensors[0].recorded_bytes, 8 * there.size());
    EXPECT_EQ(status.sensors[0].dropped, status.dropped);
    for (std::size_t i = 0; i < there.size(); ++i) {
      EXPECT_GE(there[i], i == 0 ? model_.begin : there[i - 1] + 1) << "in order, none twice";
      EXPECT_LT(there[i], bench_.next);
    }
    const std::uint64_t counted = there.size() + status.dropped;
    if (!disk_.half) {
      EXPECT_EQ(status.written, file->bytes.size());
    }
    if (status.error.empty()) {
      EXPECT_EQ(counted, read) << "recorded or dropped";
      EXPECT_EQ(status.written, file->bytes.size());
      EXPECT_TRUE(narrow_ || status.dropped == 0);
    } else {
      ++total_.failed;
      EXPECT_TRUE(model_.faulty);
      EXPECT_GE(counted, model_.least);
      EXPECT_LE(counted, std::min<std::uint64_t>(model_.least + 1, read));
    }
    total_.recorded += there.size();
    total_.dropped += status.dropped;
    if (disk_.writes < 0 && disk_.syncs < 0 && disk_.creations < 0) model_.faulty = false;
  }

  Rng rng_;
  LoggerTotal& total_;
  const std::uint64_t seed_;
  Disk disk_;
  Bench bench_;
  bool narrow_ = false;
  Model model_;
  std::string calls_;
};

TEST(LoggerSequences, EveryRecordIsInTheFileOrCountedAsDropped) {
  constexpr std::uint64_t kSchedules = 300, kLanes = 24;  // a lane mostly waits for its lines
  std::vector<LoggerTotal> totals(kLanes);
  std::atomic<std::uint64_t> next{0};
  {
    std::vector<std::jthread> lanes;
    for (std::uint64_t lane = 0; lane < kLanes; ++lane)
      lanes.emplace_back([&, lane] {
        for (std::uint64_t n = next++; n < kSchedules; n = next++)
          LoggerSequence(n, totals[lane]).run();
      });
  }
  LoggerTotal total;
  for (const LoggerTotal& t : totals) {
    total.files += t.files;
    total.recorded += t.recorded;
    total.dropped += t.dropped;
    total.failed += t.failed;
  }
  EXPECT_GT(total.files, kSchedules / 2);
  EXPECT_GT(total.recorded, kSchedules);
  EXPECT_GT(total.dropped, 0U);
  EXPECT_GT(total.failed, 0U);
}

// ---- decoders of devices ----

/// Messages without their times, which depend on the chunks by rounding. Those of nodes are packed
/// with them: their number is left.
std::string without_time(const DecodedMessage& m) {
  if (m.stream->topic.ends_with("/nodes")) return std::to_string(m.json.size());
  return m.json.substr(std::min(m.json.find('}'), m.json.size()));
}

TEST(LoggerSequences, AnyChunksGiveTheSameMessages) {
  for (const std::string& kind : device_kinds())
    for (std::uint64_t seed = 0; seed < 60; ++seed) {
      Rng rng(seed);
      tests::Stream bytes = kind == "ti_mmwave" ? tests::ti_stream(rng, 10)
                            : kind == "rplidar" ? tests::rplidar_stream(rng, 12)
                                                : tests::xbus_stream(rng, 30);
      for (auto edits = rng.below(6); edits > 0; --edits)
        bytes[rng.below(bytes.size())] = static_cast<std::uint8_t>(rng());
      constexpr int kBaud = 115200;
      const LogTime start = LogTime::from_seconds(1.7e9);
      const auto run = [&](std::uint64_t most) {
        const auto decoder = std::move(*make_decoder({"a", kind, kBaud, ""}));
        std::string all;
        std::vector<LogTime> times;
        std::map<std::string, std::size_t> of_topic;
        for (std::size_t at = 0; at < bytes.size();) {
          const std::size_t n = std::min<std::size_t>(bytes.size() - at, rng.below(most));
          at += n;
          decoder->feed(decode::Bytes(bytes).subspan(at - n, n),
                        start + decode::line_time(at, kBaud), [&](const DecodedMessage& m) {
                          all += m.stream->topic + without_time(m);
                          times.push_back(m.time);
                          ++of_topic[m.stream->topic];
                        });
        }
        const DecodingStatus s = decoder->status();
        std::size_t most_of_topic = 0;
        for (const auto& [topic, count] : of_topic) most_of_topic = std::max(most_of_topic, count);
        EXPECT_EQ(s.messages, most_of_topic);
        return std::pair(
            all + s.sample + std::to_string(s.skipped_bytes) + "," + std::to_string(s.damaged),
            times);
      };
      SCOPED_TRACE(kind + ", seed " + std::to_string(seed));
      const auto whole = run(SIZE_MAX), bytewise = run(2), pieces = run(700);
      ASSERT_EQ(bytewise.first, pieces.first);
      ASSERT_EQ(whole.first, pieces.first);
      // Each is a difference of two durations on the line, which are rounded to a nanosecond.
      for (std::size_t i = 0; i < pieces.second.size(); ++i)
        for (const auto& other : {bytewise, whole})
          EXPECT_LE(std::abs((pieces.second[i] - other.second[i]).count()), 2) << i;
    }
}

}  // namespace
}  // namespace wayfare::logger
