// The computer's clock is set while a recording is made, and stamps are set right afterwards.
#include <wayfare/logger/clock_readings.hpp>

#include <atomic>
#include <chrono>
#include <string>
#include <utility>
#include <vector>

#include "decode/xbus_streams.hpp"
#include "logger/clock_watch.hpp"
#include "logger/one_device.hpp"
#include "logger/simulated_devices.hpp"

namespace wayfare::logger {
namespace {

using namespace std::chrono_literals;
using ::testing::HasSubstr;
using ::wayfare::testing::has_read;
using ::wayfare::testing::OneDevice;
using ::wayfare::testing::TemporaryFolder;
using ::wayfare::testing::wait_for;

/// A clock that can be set.
struct SetClock {
  std::atomic<std::int64_t> ahead_ns{0};

  std::function<LogTime()> reader() {
    return [this] {
      return LogTime() + Duration(std::chrono::system_clock::now().time_since_epoch()) +
             Duration(ahead_ns.load());
    };
  }
  void set(Duration ahead) { ahead_ns = ahead.count(); }
};

LogTime second(double s) { return LogTime::from_seconds(1.7e9) + from_seconds(s); }

TEST(ClockReading, IsReadBack) {
  const ClockReading reading{second(0.000000001), second(-3600.25)};
  const std::string json = clock_reading_json(reading);
  EXPECT_THAT(json, HasSubstr("\"offset_s\":-3600.250000001"));
  EXPECT_EQ(*parse_clock_reading(json), reading);
  for (const char* text : {"", "{}", "{\"timestamp\":{\"sec\":1,\"nsec\":0}}",
                           R"({"timestamp":{"sec":1,"nsec":0},"wall":{"sec":1e300,"nsec":0}})",
                           R"({"timestamp":{"sec":1,"nsec":-1},"wall":{"sec":1,"nsec":0}})"})
    EXPECT_FALSE(parse_clock_reading(text)) << text;
}

TEST(ClockWatch, FindsStepsOnly) {
  SetClock wall;
  const LoggerClock clock(wall.reader());
  ClockWatch watch(clock);
  const auto correction_of = [&](Duration ahead) {
    wall.set(ahead);
    return watch.correction();
  };
  EXPECT_FALSE(correction_of(0s));
  EXPECT_FALSE(correction_of(200us)) << "within the uncertainty of reading";
  const LogTime before = clock.now();
  const auto back = correction_of(-1h);
  ASSERT_TRUE(back);
  EXPECT_NEAR(to_seconds(back->offset()), -3600.0, 1e-3);
  EXPECT_FALSE(correction_of(-1h));
  const auto forth = correction_of(5ms);
  ASSERT_TRUE(forth);
  EXPECT_NEAR(to_seconds(forth->offset()), 0.005, 1e-3);
  EXPECT_LT(to_seconds(clock.now() - before), 10.0) << "the clock of the stamps is not set";
}

/// A recording of a unit during which the clock is set back by an hour and a quarter of a second.
struct SetBack {
  static constexpr Duration kStep = -(1h + 250ms);

  SetBack() {
    one.options.wall_clock = wall.reader();
    one.options.sensors[0].device.kind = "xsens";
    auto logger = Logger::start(one.options);
    EXPECT_TRUE((*logger)->begin());
    path = (*logger)->status().file;
    send(**logger);
    wall.set(kStep);
    std::this_thread::sleep_for(60ms);  // three times the interval of the check
    send(**logger);
    (*logger)->stop();
    EXPECT_TRUE((*logger)->wait_until_stopped(20s));
  }
  void send(const Logger& logger) {
    for (int i = 0; i < 20; ++i) {
      decode::Stream data;
      decode::put(data, std::uint16_t{0x4020});
      decode::put<std::uint8_t>(data, 12);
      for (int k = 0; k < 3; ++k) decode::put(data, std::uint32_t{0x3F800000});
      const decode::Stream message = decode::message(decode::XbusId::mt_data2, data);
      one.send({message.begin(), message.end()});
      sent += message.size();
    }
    EXPECT_TRUE(has_read(logger, sent));
  }

  SetClock wall;
  OneDevice one;
  std::uint64_t sent = 0;
  std::string path;
};

TEST(SetBackClock, IsRecordedAndMovesNoStamp) {
  const SetBack recorded;
  const auto clock = read_clock(recorded.path);
  ASSERT_TRUE(clock);
  EXPECT_NE(clock->run, "");
  ASSERT_EQ(clock->readings.size(), 2U);
  EXPECT_NEAR(to_seconds(clock->readings[0].offset()), 0.0, 1e-3);
  EXPECT_NEAR(to_seconds(clock->readings[1].offset()), to_seconds(SetBack::kStep), 1e-3);
  const auto reader = io::McapReader::open(recorded.path);
  const auto raw = ::wayfare::testing::raw_channel(*reader, "/unit/raw");
  EXPECT_TRUE(raw.monotonic);
  EXPECT_EQ(raw.bytes.size(), recorded.sent);
  const auto& statistics = reader->contents().statistics;
  EXPECT_LT(to_seconds(statistics.last - statistics.first), 60.0);
}

TEST(SetBackClock, StampsAreSetRight) {
  const SetBack recorded;
  const Duration offset = read_clock(recorded.path)->readings.back().offset();
  const std::string copy = recorded.one.folder / "right.mcap";
  const auto moved = move_stamps(recorded.path, copy, offset);
  ASSERT_TRUE(moved) << moved.error().to_string();
  EXPECT_TRUE(moved->empty());
  const auto before = io::McapReader::open(recorded.path), after = io::McapReader::open(copy);
  ASSERT_TRUE(after);
  EXPECT_EQ(after->contents().statistics.messages, before->contents().statistics.messages);
  EXPECT_EQ(after->contents().statistics.first, before->contents().statistics.first + offset);
  EXPECT_EQ(after->contents().channels.size(), before->contents().channels.size());
  EXPECT_EQ(::wayfare::testing::raw_channel(*after, "/unit/raw").bytes,
            ::wayfare::testing::raw_channel(*before, "/unit/raw").bytes);
  // The messages' own timestamps, too.
  const auto was = read_marg_recording(recorded.path), is = read_marg_recording(copy);
  ASSERT_TRUE(was && is);
  ASSERT_EQ(is->samples.size(), 40U);
  for (std::size_t i = 0; i < 40; ++i)
    EXPECT_EQ(is->samples[i].time, was->samples[i].time + offset);
  EXPECT_EQ(read_clock(copy)->readings.back().offset(), Duration(0));
  // And back again: the same messages.
  const std::string again = recorded.one.folder / "again.mcap";
  ASSERT_TRUE(move_stamps(copy, again, -offset));
  std::vector<std::string> first, last;
  const auto gather = [](const io::McapReader& reader, std::vector<std::string>& to) {
    reader.read({}, [&](const io::McapMessage& m) {
      to.push_back(std::to_string(m.log_time.nanoseconds()) + m.channel->topic +
                   std::string(m.data));
      return true;
    });
  };
  gather(*before, first);
  gather(*io::McapReader::open(again), last);
  EXPECT_EQ(first, last);
  EXPECT_EQ(io::McapReader::open(again)->contents().metadata.at("logger").at("stamps_moved_by_s"),
            "0.000000000");
}

TEST(SetBackClock, CopiesAreRefusedWithTheirReason) {
  const SetBack recorded;
  const std::string copy = recorded.one.folder / "copy.mcap";
  EXPECT_FALSE(move_stamps(recorded.one.folder / "none.mcap", copy, 1s));
  EXPECT_FALSE(move_stamps(recorded.path, recorded.path, 1s)) << "it exists";
  const auto early = move_stamps(recorded.path, copy, -24h * 365 * 100);
  ASSERT_FALSE(early);
  EXPECT_THAT(early.error().to_string(), HasSubstr("epoch"));
  // A file without readings, and messages of others, whose timestamps are kept.
  const std::string foreign = recorded.one.folder / "foreign.mcap";
  auto writer = io::McapWriter::create(foreign);
  const auto channel = *writer->add_channel("/other", "json");
  ASSERT_TRUE(writer->write(channel, second(1), second(1), R"({"timestamp": 17})"));
  ASSERT_TRUE(writer->close());
  EXPECT_FALSE(read_clock(foreign));
  const auto kept = move_stamps(foreign, recorded.one.folder / "moved.mcap", 1s);
  ASSERT_TRUE(kept);
  EXPECT_EQ(kept->count(), 1U);
}

}  // namespace
}  // namespace wayfare::logger
