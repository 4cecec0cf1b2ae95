// Recordings of several files, and disks that become full.
#include <wayfare/logger/logger.hpp>

#include <algorithm>
#include <atomic>
#include <filesystem>
#include <string>
#include <vector>

#include <wayfare/core/random.hpp>
#include <wayfare/logger/clock_readings.hpp>
#include "logger/disk_watch.hpp"
#include "logger/one_device.hpp"
#include "logger/recorder.hpp"
#include "logger/simulated_devices.hpp"

namespace wayfare::logger {
namespace {

using namespace std::chrono_literals;
using ::testing::HasSubstr;
using ::wayfare::testing::has_read;
using ::wayfare::testing::IllDisk;
using ::wayfare::testing::OneDevice;
using ::wayfare::testing::raw_channel;
using ::wayfare::testing::TemporaryFolder;
using ::wayfare::testing::wait_for;

/// In the order of their names, which is that of the parts.
std::vector<std::string> files_of(const std::string& folder) {
  std::vector<std::string> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder))
    if (is_recording(entry.path().string())) files.push_back(entry.path().string());
  std::sort(files.begin(), files.end());
  return files;
}

/// All messages but the readings of the clock with which each file begins.
std::vector<std::string> messages_of(const std::vector<std::string>& files) {
  std::vector<std::string> messages;
  for (const std::string& file : files) {
    const auto reader = io::McapReader::open(file);
    EXPECT_TRUE(reader && reader->contents().indexed) << file;
    if (!reader) continue;
    EXPECT_TRUE(reader->contents().problems.empty()) << file;
    reader->read({}, [&](const io::McapMessage& m) {
      if (m.channel->topic != kClockTopic)
        messages.push_back(m.channel->topic + std::to_string(m.log_time.nanoseconds()) + "," +
                           std::to_string(m.publish_time.nanoseconds()) + std::string(m.data));
      return true;
    });
  }
  return messages;
}

/// The same messages into a recorder with and without rotation.
std::vector<std::string> recorded(const std::string& folder, std::uint64_t rotate_bytes) {
  LoggerOptions options;
  options.folder = folder;
  options.flush_every = 1ms;
  options.rotate_bytes = rotate_bytes;
  options.sensors.resize(3);
  const LoggerClock clock({});
  {
    Recorder recorder(options, clock, [] { return std::vector<LoggedMessage>(); });
    EXPECT_TRUE(recorder.begin({{"sensor a", "raw"}}));
    std::vector<std::shared_ptr<const Stream>> streams;
    for (const char* topic : {"/a/raw", "/b/raw", "/c/scan"})
      streams.push_back(std::make_shared<const Stream>(
          Stream{topic, "json", topic[1] == 'c' ? "schema" : "", "{}", {{"kind", topic}}}));
    Rng rng(5);
    for (int i = 0; i < 3000; ++i) {
      const std::size_t source = rng.below(3);
      std::string data(rng.below(300), static_cast<char>('a' + i % 26));
      recorder.add(recorder.session(), {source, source < 2, streams[source],
                                        LogTime::from_seconds(i), LogTime::from_seconds(i), data});
      if (i % 100 == 0) std::this_thread::sleep_for(2ms);
    }
    recorder.stop();
    EXPECT_TRUE(recorder.wait_until_stopped(20s));
  }
  return messages_of(files_of(folder));
}

TEST(Rotation, AllFilesHaveTheMessagesOfOne) {
  const TemporaryFolder one, several;
  const auto expected = recorded(one.path().string(), 0);
  EXPECT_EQ(expected.size(), 3000U);
  EXPECT_TRUE(recorded(several.path().string(), 20'000) == expected);
  EXPECT_EQ(files_of(one.path().string()).size(), 1U);
  EXPECT_GT(files_of(several.path().string()).size(), 5U);
}

/// Sends pieces until there are `files`; returns what was sent.
std::string send_until(OneDevice& one, const Logger& logger, std::uint32_t files) {
  std::string sent;
  EXPECT_TRUE(wait_for(20s, [&] {
    const std::string piece(700, static_cast<char>('a' + sent.size() / 700 % 26));
    one.send(piece);
    sent += piece;
    return logger.status().files >= files;
  }));
  return sent;
}

TEST(Rotation, EachFileIsReadAlone) {
  for (const bool by_time : {false, true}) {
    OneDevice one;
    one.options.flush_every = 5ms;
    one.options.sensors[0].device.configuration = "sensorStart";
    if (by_time) one.options.rotate_every = 100ms;
    if (!by_time) one.options.rotate_bytes = 10'000;
    auto logger = Logger::start(one.options);
    ASSERT_TRUE((*logger)->begin());
    const std::string sent = send_until(one, **logger, 4);
    ASSERT_TRUE(has_read(**logger, sent.size()));
    (*logger)->stop();
    ASSERT_TRUE((*logger)->wait_until_stopped(20s));
    const LoggerStatus status = (*logger)->status();
    const auto files = files_of(one.options.folder);
    ASSERT_EQ(files.size(), status.files);
    EXPECT_EQ(status.file, files.back());
    EXPECT_THAT(files.front(), HasSubstr("_0001.mcap"));
    EXPECT_EQ(status.sensors[0].recorded_bytes, sent.size());
    EXPECT_EQ(status.dropped, 0U);
    std::string together, run;
    std::uint64_t bytes = 0;
    for (std::size_t i = 0; i < files.size(); ++i) {
      const auto reader = io::McapReader::open(files[i]);
      ASSERT_TRUE(reader && reader->contents().indexed) << files[i];
      const auto& about = reader->contents().metadata.at("logger");
      EXPECT_EQ(about.at("sensor unit"), "raw");
      EXPECT_EQ(about.at("part"), std::to_string(i + 1));
      if (i == 0) run = about.at("run");
      EXPECT_EQ(about.at("run"), run);
      EXPECT_TRUE(read_clock(files[i])) << files[i];
      for (const io::McapChannel& channel : reader->contents().channels)
        if (channel.topic == "/unit/raw") {
          EXPECT_EQ(channel.metadata.at("configuration"), "sensorStart");
        }
      together += raw_channel(*reader, "/unit/raw").bytes;
      bytes += std::filesystem::file_size(files[i]);
    }
    EXPECT_TRUE(together == sent) << by_time;
    EXPECT_EQ(bytes, status.written);
  }
}

TEST(Rotation, AFullDiskKeepsAllFiles) {
  OneDevice one;
  IllDisk disk;
  disk.room = 60'000;
  one.options.open_sink = disk.opener();
  one.options.flush_every = 5ms;
  one.options.rotate_bytes = 10'000;
  auto logger = Logger::start(one.options);
  ASSERT_TRUE((*logger)->begin());
  std::string sent;
  ASSERT_TRUE(wait_for(20s, [&] {
    const std::string piece(500, static_cast<char>('a' + sent.size() / 500 % 26));
    one.send(piece);
    sent += piece;
    return (*logger)->status().state == LoggerState::failed;
  }));
  const LoggerStatus status = (*logger)->status();
  EXPECT_THAT(status.error, HasSubstr("no space left"));
  EXPECT_GT(status.files, 2U);
  std::string together;
  for (const std::string& file : files_of(one.options.folder)) {
    const auto reader = io::McapReader::open(file);
    ASSERT_TRUE(reader) << file;
    together += raw_channel(*reader, "/unit/raw").bytes;
  }
  EXPECT_EQ(together.size(), status.sensors[0].recorded_bytes);
  EXPECT_GT(together.size(), 20'000U);
  EXPECT_EQ(together, sent.substr(0, together.size()));
}

TEST(Rotation, WithoutANextFileTheLastOneGoesOn) {
  OneDevice one;
  std::atomic<int> opened{0};
  one.options.open_sink = [&](const std::string& path) -> Result<std::unique_ptr<io::ByteSink>> {
    if (opened++ > 0) return Error{ErrorCode::io, "no more files", path};
    return io::FileSink::create(path);
  };
  one.options.flush_every = 5ms;
  one.options.rotate_bytes = 5'000;
  auto logger = Logger::start(one.options);
  ASSERT_TRUE((*logger)->begin());
  std::string sent;
  for (int i = 0; i < 40; ++i, std::this_thread::sleep_for(2ms)) {
    one.send(std::string(500, 'a'));
    sent += std::string(500, 'a');
  }
  ASSERT_TRUE(has_read(**logger, sent.size()));
  EXPECT_THAT((*logger)->status().warning, HasSubstr("no next file: "));
  EXPECT_EQ(opened, 2) << "it is not tried again at once";
  (*logger)->stop();
  ASSERT_TRUE((*logger)->wait_until_stopped(20s));
  EXPECT_EQ((*logger)->status().files, 1U);
  EXPECT_EQ(raw_channel(*io::McapReader::open((*logger)->status().file), "/unit/raw").bytes, sent);
}

// --- the time until a disk is full ---------------------------------------------------------------

LogTime second(double s) { return LogTime::from_seconds(1e9 + s); }

TEST(DiskWatch, TellsTheTimeLeft) {
  DiskWatch watch;
  watch.add(second(0.0), 0, 600'000'000);
  EXPECT_FALSE(watch.seconds_left());
  for (int s = 1; s <= 20; ++s)
    watch.add(second(s), 1'000'000ULL * static_cast<unsigned>(s),
              600'000'000 - 1'000'000ULL * static_cast<unsigned>(s));
  // 1 MB/s, 580 MB left.
  EXPECT_NEAR(watch.rate().value_or(0.0), 1e6, 1.0);
  EXPECT_NEAR(watch.seconds_left().value_or(0.0), 580.0, 0.1);
  // Another program takes nine times as much.
  for (int s = 1; s <= 20; ++s)
    watch.add(second(20 + s), 20'000'000 + 1'000'000ULL * static_cast<unsigned>(s),
              580'000'000 - 10'000'000ULL * static_cast<unsigned>(s));
  EXPECT_NEAR(watch.seconds_left().value_or(0.0), 38.0, 0.1);
  // Another recording, a disk that does not fill.
  watch.add(second(41.0), 0, 900'000'000);
  EXPECT_FALSE(watch.seconds_left());
  watch.add(second(43.0), 0, 900'000'000);
  EXPECT_FALSE(watch.seconds_left());
}

TEST(DiskWatch, ALoggerWarns) {
  OneDevice one;
  one.options.warn_disk = 24h * 365 * 200;  // every disk is full by then
  auto logger = Logger::start(one.options);
  ASSERT_TRUE((*logger)->begin());
  EXPECT_TRUE(wait_for(20s, [&] {
    one.send(std::string(1000, 'a'));
    return (*logger)->status().warning.find("the disk is full in ") == 0;
  }));
  EXPECT_THAT(to_json((*logger)->status()), HasSubstr("\"warning\":\"the disk is full in "));
  (*logger)->stop();
  ASSERT_TRUE((*logger)->wait_until_stopped(20s));
  EXPECT_EQ((*logger)->status().warning, "");
}

}  // namespace
}  // namespace wayfare::logger
