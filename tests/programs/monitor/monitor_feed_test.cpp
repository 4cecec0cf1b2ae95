// What a running logger records, pushed to listeners of any speed.

#include <algorithm>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "monitor/live_feed.hpp"
#include "monitor/live_link.hpp"
#include "monitor/recording_tail.hpp"

#include "monitor_support.hpp"

namespace wayfare::examples {
namespace {

using nlohmann::json;

/// A logger that says what a test wants, and its recording.
struct SpokenLogger {
  explicit SpokenLogger(const std::string& name = "growing.mcap") : path(folder / name) {
    writer.emplace(*io::McapWriter::create(path));
  }
  void say(const std::string& state, const std::string& file) {
    const std::string line = logger::status_line(
        json({{"state", state}, {"file", file}, {"sensors", json::array()}}).dump());
    const std::span bytes(reinterpret_cast<const std::uint8_t*>(line.data()), line.size());
    LiveFeed::Listener probe;
    // What is sent before the line is open is lost.
    EXPECT_TRUE(wait_for(20s, [&] {
      return terminal.write(bytes, 1000ms) && feed.wait(probe, 300ms).find(file) != file.npos;
    }));
  }
  std::uint16_t channel(const std::string& topic, const std::string& encoding = "json") {
    return *writer->add_channel(topic, encoding);
  }
  void put(std::uint16_t channel, int number, std::size_t size = 1) {
    const std::string text = json({{"n", number}, {"pad", std::string(size, 'x')}}).dump();
    EXPECT_TRUE(writer->write(channel, at(0.001 * number), at(0.001 * number), text));
  }
  TemporaryFolder folder;
  std::string path;
  std::optional<io::McapWriter> writer;
  logger::PseudoTerminal terminal = std::move(*logger::PseudoTerminal::open());
  LiveLink link{terminal.path(), 115200};
  LiveFeed feed{link};
};

/// The numbers of the messages of a topic in events, in their order.
std::vector<int> numbers_of(const std::string& events, const std::string& topic) {
  std::vector<int> numbers;
  const std::string head = "data: {\"topic\":\"" + topic + "\"";
  for (std::size_t at = 0; (at = events.find(head, at)) != events.npos;) {
    at = events.find('\n', at) + 1;
    numbers.push_back(json::parse(events.substr(at + 6, events.find('\n', at) - at - 6))["n"]);
  }
  return numbers;
}

/// The sum of the last event `missed`.
int missed_in(const std::string& events) {
  const std::string head = "event: missed\ndata: ";
  const auto at = events.rfind(head);
  if (at == events.npos) return 0;
  const auto begin = at + head.size();
  const json missed = json::parse(events.substr(begin, events.find('\n', begin) - begin));
  int sum = 0;
  for (const json& n : missed) sum += n.get<int>();
  return sum;
}

/// What a listener gets until the last message of a topic has the number.
std::string listen_until(const LiveFeed& feed, LiveFeed::Listener& listener,
                         const std::string& topic, int number) {
  std::string events;
  EXPECT_TRUE(wait_for(20s, [&] {
    events += feed.wait(listener, 100ms);
    const auto numbers = numbers_of(events, topic);
    return !numbers.empty() && numbers.back() == number;
  }));
  return events;
}

TEST(MonitorFeed, PassesOnEveryMessageOnce) {
  SpokenLogger logger;
  const auto wanted = logger.channel("/wanted"), other = logger.channel("/other");
  const auto bytes = logger.channel("/wanted/raw", "application/octet-stream");
  LiveFeed::Listener listener{{"/wanted", "/wanted/raw"}};
  logger.say("recording", logger.path);
  std::string events;
  for (int i = 0; i < 500; ++i) {
    logger.put(wanted, i);
    logger.put(other, i);
    EXPECT_TRUE(logger.writer->write(bytes, at(0.0), at(0.0), "\x01\n"));
    if (i % 50 == 49) {
      EXPECT_TRUE(logger.writer->flush());
    }
    if (i % 100 == 99) events += listen_until(logger.feed, listener, "/wanted", i);
  }
  std::vector<int> all(500);
  for (int i = 0; i < 500; ++i) all[static_cast<std::size_t>(i)] = i;
  EXPECT_EQ(numbers_of(events, "/wanted"), all);
  EXPECT_THAT(numbers_of(events, "/other"), ::testing::IsEmpty());
  EXPECT_EQ(missed_in(events), 0);
  // Contents are pushed, too.
  EXPECT_TRUE(wait_for(20s, [&] {
    events += logger.feed.wait(listener, 100ms);
    return events.find("event: contents") != events.npos &&
           events.find("\"messages\":1500", events.rfind("event: contents")) != events.npos;
  }));
}

TEST(MonitorFeed, ASlowListenerGetsTheNewestAndTheCountOfTheOthers) {
  SpokenLogger logger;
  const auto many = logger.channel("/many"), few = logger.channel("/few");
  LiveFeed::Listener slow{{"/many", "/few"}}, quick{{"/end"}};
  const auto end = logger.channel("/end");
  logger.say("recording", logger.path);
  logger.put(few, 7);
  logger.put(many, 0);
  EXPECT_TRUE(logger.writer->flush());
  listen_until(logger.feed, slow, "/many", 0);
  // More than the feed keeps.
  constexpr int kMessages = 2000;
  for (int i = 1; i <= kMessages; ++i) {
    logger.put(many, i, 10'000);
    if (i % 100 == 0) {
      EXPECT_TRUE(logger.writer->flush());
    }
  }
  logger.put(end, 1);
  EXPECT_TRUE(logger.writer->flush());
  listen_until(logger.feed, quick, "/end", 1);
  EXPECT_LE(logger.feed.bytes(), std::size_t{8} << 20);
  const std::string events = logger.feed.wait(slow, 1000ms);
  EXPECT_EQ(numbers_of(events, "/many"), std::vector{kMessages});
  EXPECT_EQ(missed_in(events), kMessages - 1);
  EXPECT_TRUE(numbers_of(events, "/few").empty());
  // Then it has caught up.
  logger.put(many, kMessages + 1);
  EXPECT_TRUE(logger.writer->flush());
  EXPECT_EQ(missed_in(listen_until(logger.feed, slow, "/many", kMessages + 1)), 0);
}

TEST(MonitorFeed, OfAnOldRecordingTheNewestOfEachTopicCounts) {
  SpokenLogger logger;
  const auto latched = logger.channel("/tf_static"), many = logger.channel("/many");
  logger.put(latched, 5);
  for (int i = 0; i < 3000; ++i) {
    logger.put(many, i, 1000);
    if (i % 100 == 99) {
      EXPECT_TRUE(logger.writer->flush());
    }
  }
  // It begins to listen before the feed has read the file.
  LiveFeed::Listener listener{{"/tf_static", "/many"}};
  static_cast<void>(logger.feed.wait(listener, 1ms));
  logger.say("recording", logger.path);
  const std::string events = listen_until(logger.feed, listener, "/many", 2999);
  EXPECT_EQ(numbers_of(events, "/tf_static"), std::vector{5});
  EXPECT_EQ(missed_in(events), 0);
  logger.put(many, 3000);
  EXPECT_TRUE(logger.writer->flush());
  const std::string more = listen_until(logger.feed, listener, "/many", 3000);
  EXPECT_EQ(numbers_of(more, "/many"), std::vector{3000});
  EXPECT_EQ(missed_in(more), 0);
  // A new listener gets what is kept of the last moments.
  LiveFeed::Listener late{{"/tf_static", "/many"}};
  const std::string last = logger.feed.wait(late, 1000ms);
  EXPECT_EQ(numbers_of(last, "/tf_static"), std::vector{5});
  EXPECT_EQ(numbers_of(last, "/many").back(), 3000);
}

TEST(MonitorFeed, SurvivesWhatIsNoRecording) {
  SpokenLogger logger;
  ASSERT_TRUE(io::write_file(logger.folder / "text.mcap", "no recording"));
  // A record that is longer than the file, or than any.
  const std::string magic = "\x89MCAP0\r\n";
  ASSERT_TRUE(io::write_file(logger.folder / "long.mcap", magic + "\x06" + std::string(8, '\x7f')));
  ASSERT_TRUE(io::write_file(logger.folder / "short.mcap",
                             magic + "\x06\x04" + std::string(7, '\0') + "ab"));
  ASSERT_TRUE(io::write_file(logger.folder / "odd.mcap",
                             magic + "\x06\x04" + std::string(7, '\0') + "abcd"));
  for (const std::string name : {"none.mcap", "text.mcap", "long.mcap", "short.mcap", "odd.mcap"}) {
    RecordingTail tail(logger.folder / name);
    int messages = 0;
    for (int i = 0; i < 3; ++i) tail.poll([&](const auto&, bool) { ++messages; });
    EXPECT_EQ(messages, 0) << name;
    logger.say("recording", logger.folder / name);
  }
  EXPECT_TRUE(logger.terminal.write(std::vector<std::uint8_t>{'[', '\n'}, 1000ms));
  const auto wanted = logger.channel("/wanted");
  logger.put(wanted, 1);
  EXPECT_TRUE(logger.writer->flush());
  logger.say("recording", logger.path);
  LiveFeed::Listener listener{{"/wanted"}};
  listen_until(logger.feed, listener, "/wanted", 1);
}

}  // namespace
}  // namespace wayfare::examples
