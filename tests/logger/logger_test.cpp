// The logger with devices on pseudo-terminals and stalled or full disks.
// WAYFARE_LOGGER_TRIAL=long makes LosesNothingWhenTheDiskStandsStill take two minutes.
#include <wayfare/logger/logger.hpp>

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <string>
#include <thread>
#include <vector>

#include "logger/one_device.hpp"
#include "logger/simulated_devices.hpp"

namespace wayfare::logger {
namespace {

using namespace std::chrono_literals;
using ::testing::HasSubstr;
using ::wayfare::testing::four_devices;
using ::wayfare::testing::has_read;
using ::wayfare::testing::IllDisk;
using ::wayfare::testing::OneDevice;
using ::wayfare::testing::Played;
using ::wayfare::testing::raw_channel;
using ::wayfare::testing::sensor;
using ::wayfare::testing::SimulatedDevice;
using ::wayfare::testing::TemporaryFolder;
using ::wayfare::testing::wait_for;

TEST(Logger, LosesNothingWhenTheDiskStandsStill) {
  const char* trial = std::getenv("WAYFARE_LOGGER_TRIAL");
  const bool full = trial != nullptr && std::string(trial) == "long";
  const double seconds = full ? 120.0 : 2.0;
  const int stall_ms = full ? 2000 : 400;
  const TemporaryFolder folder;
  IllDisk disk;
  LoggerOptions options;
  options.folder = folder.path().string();
  options.open_sink = disk.opener();
  std::vector<std::unique_ptr<Played>> devices;
  for (const SimulatedDevice& d : four_devices()) {
    devices.push_back(std::make_unique<Played>(d, 10.0, seconds));
    options.sensors.push_back(sensor(d.description, devices.back()->path()));
  }
  auto logger = Logger::start(options);
  ASSERT_TRUE(logger);
  ASSERT_TRUE((*logger)->begin());
  for (auto& device : devices) device->start();
  for (int i = 0; i < 2; ++i) {
    std::this_thread::sleep_for(std::chrono::duration<double>(seconds / 4.0));
    disk.stall_ms = stall_ms;
  }
  for (auto& device : devices) device->finish();
  EXPECT_TRUE(wait_for(20s, [&] {
    const LoggerStatus s = (*logger)->status();
    for (std::size_t i = 0; i < 4; ++i)
      if (s.sensors[i].bytes != devices[i]->bytes().size()) return false;
    return true;
  }));
  (*logger)->stop();
  ASSERT_TRUE((*logger)->wait_until_stopped(20s));
  const LoggerStatus status = (*logger)->status();
  EXPECT_EQ(status.state, LoggerState::idle);
  EXPECT_EQ(status.dropped, 0U);
  const auto reader = io::McapReader::open(status.file);
  ASSERT_TRUE(reader);
  EXPECT_TRUE(reader->contents().indexed);
  std::uint64_t all = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    const auto raw = raw_channel(*reader, "/" + status.sensors[i].name + "/raw");
    EXPECT_TRUE(raw.bytes == devices[i]->bytes()) << i;
    EXPECT_TRUE(raw.monotonic) << i;
    all += raw.bytes.size();
  }
  // Figures of the trial: read with --gtest_brief=0 or in the test's XML.
  RecordProperty("raw_bytes", std::to_string(all));
  RecordProperty("file_bytes", std::to_string(std::filesystem::file_size(status.file)));
  RecordProperty("queue_peak_bytes", std::to_string(status.queue_peak));
  std::printf("%.0f s: %llu raw bytes in %llu records, queue at most %zu bytes\n", seconds,
              static_cast<unsigned long long>(all),
              static_cast<unsigned long long>(reader->contents().statistics.messages),
              status.queue_peak);
}

TEST(Logger, CountsDroppedRecords) {
  OneDevice one;
  IllDisk disk;
  one.options.open_sink = disk.opener();
  one.options.queue_bytes = 20'000;
  one.options.flush_every = 10ms;
  auto logger = Logger::start(one.options);
  ASSERT_TRUE((*logger)->begin());
  disk.stuck = true;
  one.send(std::string(1000, 'a'));
  ASSERT_TRUE(wait_for(20s, [&] { return disk.waiting > 0; }));
  for (int i = 0; i < 60; ++i) one.send(std::string(1000, 'b'));
  EXPECT_TRUE(has_read(**logger, 61'000));
  disk.stuck = false;
  (*logger)->stop();
  ASSERT_TRUE((*logger)->wait_until_stopped(20s));
  const LoggerStatus status = (*logger)->status();
  EXPECT_GT(status.dropped, 0U);
  EXPECT_LE(status.queue_peak, 20'000U);
  // The other records are in the file.
  const auto raw = raw_channel(*io::McapReader::open(status.file), "/unit/raw");
  EXPECT_EQ(raw.bytes.size(), status.sensors[0].recorded_bytes);
  EXPECT_LT(raw.bytes.size(), 61'000U);
}

TEST(Logger, AFullDiskEndsTheRecordingAndKeepsIt) {
  OneDevice one;
  IllDisk disk;
  disk.room = 30'000;
  one.options.open_sink = disk.opener();
  one.options.flush_every = 10ms;
  auto logger = Logger::start(one.options);
  ASSERT_TRUE((*logger)->begin());
  std::string sent;
  for (int i = 0; (*logger)->status().state == LoggerState::recording && i < 500; ++i) {
    std::string piece(500, static_cast<char>('a' + i % 26));
    one.send(piece);
    sent += piece;
    std::this_thread::sleep_for(5ms);
  }
  EXPECT_TRUE(wait_for(20s, [&] { return (*logger)->status().state == LoggerState::failed; }));
  const LoggerStatus status = (*logger)->status();
  EXPECT_THAT(status.error, HasSubstr("no space left"));
  const auto reader = io::McapReader::open(status.file);
  ASSERT_TRUE(reader);
  const auto raw = raw_channel(*reader, "/unit/raw");
  EXPECT_GT(raw.bytes.size(), 20'000U);
  EXPECT_EQ(raw.bytes, sent.substr(0, raw.bytes.size()));
  // With room on the disk the next command starts another.
  disk.room = UINT64_MAX;
  EXPECT_TRUE((*logger)->begin());
  (*logger)->stop();
  ASSERT_TRUE((*logger)->wait_until_stopped(20s));
  EXPECT_NE((*logger)->status().file, status.file);
  EXPECT_EQ((*logger)->status().error, "");
}

TEST(Logger, ReportsThatARecordingCannotBeCreated) {
  OneDevice one;
  one.options.folder = (one.folder / "none");
  auto logger = Logger::start(one.options);
  const auto begun = (*logger)->begin();
  ASSERT_FALSE(begun);
  EXPECT_EQ((*logger)->status().state, LoggerState::failed);
  EXPECT_THAT((*logger)->status().error, HasSubstr("cannot be created"));
}

TEST(Logger, SurvivesADeviceThatIsUnplugged) {
  OneDevice one;
  auto logger = Logger::start(one.options);
  ASSERT_TRUE((*logger)->begin());
  one.send("before");
  ASSERT_TRUE(has_read(**logger, 6));
  // Another terminal replaces it under the same name.
  const std::string link = one.folder / "port";
  OneDevice gone_too, other;
  std::filesystem::create_symlink(gone_too.terminal.path(), link);
  other.options.sensors[0].port = link;
  auto second = Logger::start(other.options);
  ASSERT_TRUE(
      wait_for(20s, [&] { return (*second)->status().sensors[0].state != SensorState::waiting; }));
  { const PseudoTerminal gone = std::move(one.terminal), linked = std::move(gone_too.terminal); }
  EXPECT_TRUE(wait_for(20s, [&] {
    return (*logger)->status().sensors[0].state == SensorState::waiting &&
           (*second)->status().sensors[0].state == SensorState::waiting;
  }));
  EXPECT_NE((*second)->status().sensors[0].note, "");
  std::filesystem::remove(link);
  std::filesystem::create_symlink(other.terminal.path(), link);
  other.send("after");
  EXPECT_TRUE(has_read(**second, 5));
}

TEST(Logger, RefusesInvalidOptions) {
  OneDevice one;
  LoggerOptions none = one.options, twice = one.options, kind = one.options, port = one.options;
  none.sensors.clear();
  twice.sensors.push_back(twice.sensors[0]);
  kind.sensors[0].device.kind = "sonar";
  port.control_port = "/nowhere/tty";
  for (const LoggerOptions& o : {none, twice, kind, port}) EXPECT_FALSE(Logger::start(o));
}

// --- remote control ------------------------------------------------------------------------------

/// The other end of a control line: sends commands and reads whole status lines.
class Remote {
 public:
  explicit Remote(PseudoTerminal& terminal) : terminal_(terminal) {}
  void send(const std::string& commands) {
    const auto* data = reinterpret_cast<const std::uint8_t*>(commands.data());
    EXPECT_TRUE(terminal_.write({data, commands.size()}, 1s));
  }
  /// Whether a status of that state arrives within twenty seconds.
  bool sees(const std::string& state) {
    return wait_for(20s, [&] {
      std::uint8_t buffer[4096];
      const auto n = terminal_.read(buffer, 20ms);
      if (n) text_.append(reinterpret_cast<const char*>(buffer), *n);
      bool seen = false;
      for (std::size_t end; (end = text_.find('\n')) != text_.npos; text_.erase(0, end + 1)) {
        const auto status = status_of_line(std::string_view(text_).substr(0, end));
        seen = seen || (status && status->find("\"state\":\"" + state + "\",") != status->npos);
      }
      return seen;
    });
  }

 private:
  PseudoTerminal& terminal_;
  std::string text_;
};

TEST(Logger, FollowsRepeatedRemoteCommands) {
  OneDevice one;
  auto line = PseudoTerminal::open();
  one.options.control_port = line->path();
  auto logger = Logger::start(one.options);
  ASSERT_TRUE(logger);
  Remote remote(*line);
  EXPECT_TRUE(remote.sees("idle"));
  remote.send("xyBq\n");
  EXPECT_TRUE(remote.sees("recording"));
  const std::string file = (*logger)->status().file;
  remote.send("BBB");
  one.send("data");
  ASSERT_TRUE(has_read(**logger, 4));
  EXPECT_TRUE(remote.sees("recording"));
  EXPECT_EQ((*logger)->status().file, file);
  remote.send("SS");
  EXPECT_TRUE(remote.sees("idle"));
  EXPECT_EQ(raw_channel(*io::McapReader::open(file), "/unit/raw").bytes, "data");
  remote.send("B");
  EXPECT_TRUE(remote.sees("recording"));
  EXPECT_NE((*logger)->status().file, file);
  remote.send("T");
  EXPECT_TRUE(remote.sees("terminated"));
  remote.send("B");
  std::this_thread::sleep_for(100ms);
  EXPECT_EQ((*logger)->status().state, LoggerState::terminated);
  EXPECT_TRUE(io::McapReader::open((*logger)->status().file)->contents().indexed);
}

TEST(Logger, FollowsCommandsOnASocket) {
  OneDevice one;
  one.options.control_socket = one.folder / "control";
  auto logger = Logger::start(one.options);
  ASSERT_TRUE(logger);
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::memcpy(address.sun_path, one.options.control_socket.c_str(),
              one.options.control_socket.size());
  const auto connect = [&] {
    const int fd = ::socket(AF_UNIX, SOCK_STREAM, 0);
    EXPECT_EQ(::connect(fd, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
    return fd;
  };
  // One client that never reads, one that leaves, and one that sends commands.
  const int deaf = connect(), leaving = connect(), fd = connect();
  ::close(leaving);
  ASSERT_EQ(::send(fd, "B", 1, 0), 1);
  EXPECT_TRUE(wait_for(20s, [&] { return (*logger)->status().state == LoggerState::recording; }));
  std::string text;
  EXPECT_TRUE(wait_for(20s, [&] {
    char buffer[4096];
    const ssize_t n = ::recv(fd, buffer, sizeof buffer, MSG_DONTWAIT);
    if (n > 0) text.append(buffer, static_cast<std::size_t>(n));
    const auto end = text.rfind('\n');
    if (end == text.npos) return false;
    const auto begin = text.rfind('\n', end - 1);
    const std::size_t from = begin == text.npos ? 0 : begin + 1;
    const std::string line = text.substr(from, end - from);
    const auto status = status_of_line(line);
    return status && status->find("\"recording\"") != status->npos;
  }));
  ::close(fd);
  ::close(deaf);
}

TEST(Logger, RecordsItsStatusAndDecodedMessages) {
  WAYFARE_NEEDS_RECORDING(path, "devices/ti_mmwave/awr1843_sdk3.6/mer1.dat.gz");
  OneDevice one;
  one.options.sensors[0].device = {"radar", "ti_mmwave", 921600, ""};
  auto logger = Logger::start(one.options);
  ASSERT_TRUE(logger) << logger.error().to_string();
  ASSERT_TRUE((*logger)->begin());
  const auto capture = io::read_file(path);
  ASSERT_TRUE(capture) << capture.error().to_string();
  const auto rate = [&] { return (*logger)->status().sensors[0].bytes_per_s; };
  // The rate of one interval may be missed by a test that waits for the processor: the device sends
  // until it is seen.
  constexpr std::size_t kPiece = 1000;
  const std::size_t pieces = capture->bytes.size() / kPiece;
  std::string bytes;
  const auto send_and_look = [&] {
    bytes += capture->bytes.substr(bytes.size() % (pieces * kPiece), kPiece);
    one.send(bytes.substr(bytes.size() - kPiece));
    return bytes.size() >= 100'000 && rate() > 0.0;
  };
  EXPECT_TRUE(wait_for(20s, send_and_look));
  ASSERT_TRUE(has_read(**logger, bytes.size()));
  EXPECT_TRUE(wait_for(20s, [&] { return rate() == 0.0; }));
  (*logger)->stop();
  ASSERT_TRUE((*logger)->wait_until_stopped(20s));
  const LoggerStatus status = (*logger)->status();
  const auto reader = io::McapReader::open(status.file);
  ASSERT_TRUE(reader) << reader.error().to_string();
  std::map<std::string, std::size_t> count;
  reader->read({}, [&](const io::McapMessage& m) {
    ++count[m.channel->topic];
    return true;
  });
  EXPECT_EQ(count["/radar/points"], status.sensors[0].decoding.messages);
  EXPECT_GT(count["/radar/points"], 20U);
  EXPECT_GT(count["/logger/status"], 0U);
  EXPECT_EQ(raw_channel(*reader, "/radar/raw").bytes, bytes);
  for (const io::McapChannel& c : reader->contents().channels) {
    if (c.topic != "/radar/raw") continue;
    EXPECT_EQ(c.metadata.at("kind"), "ti_mmwave");
  }
  EXPECT_EQ(reader->contents().metadata.at("logger").at("sensor radar"), "ti_mmwave");
}

}  // namespace
}  // namespace wayfare::logger
