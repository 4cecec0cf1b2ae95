// An RPLIDAR that is started by its protocol, unplugged and plugged in again.
#include <wayfare/logger/logger.hpp>

#include <array>
#include <atomic>
#include <filesystem>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <utility>

#include "decode/simulated_rplidar.hpp"
#include "logger/one_device.hpp"
#include "logger/simulated_devices.hpp"

namespace wayfare::logger {
namespace {

using namespace std::chrono_literals;
using ::testing::HasSubstr;
using ::wayfare::testing::raw_channel;
using ::wayfare::testing::sensor;
using ::wayfare::testing::TemporaryFolder;
using ::wayfare::testing::wait_for;

/// The device on a terminal that has a name.
class PluggedRplidar {
 public:
  explicit PluggedRplidar(std::string link) : link_(std::move(link)) { plug(); }
  ~PluggedRplidar() { unplug(); }

  void plug() {
    std::filesystem::remove(link_);
    terminal_.emplace(std::move(*PseudoTerminal::open()));
    std::filesystem::create_symlink(terminal_->path(), link_);
    stop_ = false;
    thread_ = std::thread([this] { run(); });
  }
  void unplug() {
    stop_ = true;
    if (thread_.joinable()) thread_.join();
    terminal_.reset();
  }

  /// To be set while it is unplugged.
  decode::SimulatedRplidar device;
  /// That were passed to the logger.
  [[nodiscard]] std::string sent() const {
    const std::lock_guard lock(mutex_);
    return sent_;
  }

 private:
  void run() {
    auto last = std::chrono::steady_clock::now();
    while (!stop_) {
      std::array<std::uint8_t, 256> request;
      const auto n = terminal_->read(request, 5ms).value_or(0);
      device.take(decode::Bytes(request).first(n));
      const auto now = std::chrono::steady_clock::now();
      const decode::Stream bytes = device.sent(now - std::exchange(last, now));
      const auto written = terminal_->write(bytes, 100ms).value_or(0);
      const std::lock_guard lock(mutex_);
      sent_.append(bytes.begin(), bytes.begin() + static_cast<long>(written));
    }
  }

  std::string link_, sent_;
  std::optional<PseudoTerminal> terminal_;
  mutable std::mutex mutex_;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

TEST(LoggerOfAnRplidar, StartsItAndAgainWhereTheLineWasUnplugged) {
  const TemporaryFolder folder;
  PluggedRplidar lidar(folder / "port");
  LoggerOptions options;
  options.folder = folder.path().string();
  options.sensors = {sensor({"lidar", "rplidar", 115200, ""}, folder / "port")};
  options.sensors[0].mode = "standard";
  auto logger = Logger::start(options);
  ASSERT_TRUE(logger);
  ASSERT_TRUE((*logger)->begin());
  const auto now = [&] { return (*logger)->status().sensors[0]; };
  ASSERT_TRUE(wait_for(20s, [&] { return now().decoding.messages > 1; })) << now().warning;
  EXPECT_THAT(now().note, HasSubstr("A1M8, firmware 1.29"));
  EXPECT_THAT(now().note, HasSubstr("mode Standard"));
  EXPECT_EQ(now().warning, "");
  lidar.unplug();
  ASSERT_TRUE(wait_for(20s, [&] { return now().state == SensorState::waiting; }));
  EXPECT_NE(now().note, "");
  const std::uint64_t before = now().decoding.messages;
  lidar.device = {};  // without power it forgets its scan
  lidar.plug();
  ASSERT_TRUE(wait_for(20s, [&] { return now().decoding.messages > before + 1; }))
      << now().warning << now().note;
  EXPECT_EQ(lidar.device.count(0x20), 1U);
  lidar.unplug();
  ASSERT_TRUE(wait_for(20s, [&] { return now().state == SensorState::waiting; }));
  (*logger)->stop();
  ASSERT_TRUE((*logger)->wait_until_stopped(20s));
  const auto reader = io::McapReader::open((*logger)->status().file);
  // What was in the line when it was unplugged is gone, and nothing else.
  const std::string sent = lidar.sent(), read = raw_channel(*reader, "/lidar/raw").bytes;
  EXPECT_GE(read.size() + 8192, sent.size());
  EXPECT_GE(reader->contents().statistics.messages, before);
}

TEST(LoggerOfAnRplidar, ListensOnlyWhereItIsToldTo) {
  const TemporaryFolder folder;
  PluggedRplidar lidar(folder / "port");
  lidar.unplug();
  lidar.device.scan(decode::RplidarResponse::node);
  lidar.plug();
  LoggerOptions options;
  options.folder = folder.path().string();
  options.sensors = {sensor({"lidar", "rplidar", 115200, ""}, folder / "port")};
  options.sensors[0].mode = "listen";
  auto logger = Logger::start(options);
  ASSERT_TRUE(logger);
  EXPECT_TRUE(wait_for(20s, [&] { return (*logger)->status().sensors[0].decoding.messages > 1; }));
  logger->reset();
  lidar.unplug();
  EXPECT_TRUE(lidar.device.commands.empty());
  options.sensors[0].device.kind = "raw";
  EXPECT_FALSE(Logger::start(options));
}

}  // namespace
}  // namespace wayfare::logger
