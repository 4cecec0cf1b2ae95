// Decoding of a device's bytes to stamped messages.
#include <wayfare/logger/device_decoder.hpp>

#include <limits>
#include <string>
#include <vector>

#include <wayfare/decode/rplidar_stream.hpp>
#include <wayfare/decode/stream_decoder.hpp>
#include <wayfare/io/text_file.hpp>
#include <wayfare/logger/messages.hpp>
#include "io/support.hpp"
#include "logger/status_sample.hpp"

namespace wayfare::logger {
namespace {

using namespace std::chrono_literals;
using ::testing::HasSubstr;

LogTime start() { return LogTime::from_nanoseconds(1'700'000'000'000'000'000); }

/// Passes a capture at the line's rate; returns the messages.
std::vector<DecodedMessage> decode_at(DeviceDecoder& decoder, const std::string& bytes,
                                      double bytes_per_s, std::size_t piece) {
  std::vector<DecodedMessage> messages;
  for (std::size_t at = 0; at < bytes.size(); at += piece) {
    const std::size_t n = std::min(piece, bytes.size() - at);
    decoder.feed({reinterpret_cast<const std::uint8_t*>(bytes.data()) + at, n},
                 start() + from_seconds(static_cast<double>(at + n) / bytes_per_s),
                 [&](DecodedMessage m) { messages.push_back(std::move(m)); });
  }
  return messages;
}

TEST(LineTime, TenBitsPerByte) {
  EXPECT_EQ(decode::line_time(11'520, 115'200), 1s);
  EXPECT_EQ(decode::line_time(0, 300), 0s);
}

TEST(DeviceStreams, GiveNothingForNoise) {
  const std::vector<std::uint8_t> noise(10'000, 0x55);
  TiStream radar(921'600);
  decode::RplidarStream lidar(115'200);
  radar.feed(noise, start(), [](const RadarScan&) { FAIL(); });
  lidar.feed(noise, start(), [](const decode::RplidarRevolution&) { FAIL(); });
  EXPECT_EQ(radar.statistics().bytes, noise.size());
  EXPECT_EQ(lidar.statistics().frames, 0U);
}

TEST(DeviceDecoder, KnowsItsKinds) {
  for (const std::string& kind : device_kinds()) EXPECT_TRUE(make_decoder({"a", kind, 115200, ""}));
  const auto unknown = make_decoder({"a", "sonar", 115200, ""});
  ASSERT_FALSE(unknown);
  EXPECT_THAT(unknown.error().message, HasSubstr("raw, ti_mmwave"));
  EXPECT_FALSE(make_decoder({"a", "ti_mmwave", 921600, "profileCfg nonsense"}));
}

// Numbers that are not finite or beyond all sensors are null; nothing of a scan without returns.
TEST(StatusSample, IsShortAndHasNoNumbersThatJsonLacks) {
  const LogTime time = LogTime::from_nanoseconds(1'700'000'000'012'345'678);
  MargSample unit{time, {0.25, 1e300, 0.0}, {1.0, -2.0, 9.816}};
  unit.angular_rate_radps.z() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(status_sample(unit),
            R"({"t":1700000000.012,"force":[1.00,-2.00,9.82],"rate":[0.250,null,null]})");
  LaserScan scan{time, Angle::degrees(-180.0), Angle::degrees(1.0), 0.1F, 12.0F, {}};
  EXPECT_EQ(status_sample(scan),
            R"({"t":1700000000.012,"from_deg":-180.00,"step_deg":1.0000,"cm":[]})");
  scan.ranges_m.assign(1000, std::numeric_limits<float>::infinity());
  scan.ranges_m[20] = 3.0F, scan.ranges_m[21] = 2.5F;
  const std::string text = status_sample(scan);
  EXPECT_THAT(text, HasSubstr(R"("cm":[null,250,null)"));
  EXPECT_LT(text.size(), 600U);
  RadarScan radar{time, {}};
  for (int i = 0; i < 100; ++i)
    radar.points.push_back({1.0F, -0.5F, 0.0F, 0.25F, static_cast<float>(i)});
  EXPECT_THAT(status_sample(radar), HasSubstr(R"("cm":[[100,-50,25],)"));
  EXPECT_LT(status_sample(radar).size(), 600U);
}

TEST(DeviceDecoder, RadarFramesAreStampedByTheirOwnClock) {
  WAYFARE_NEEDS_RECORDING(path, "devices/ti_mmwave/awr1843_sdk3.6/mer1.dat.gz");
  const std::string bytes = io::read_file(path)->bytes;
  auto decoder = make_decoder({"radar", "ti_mmwave", 921600, ""});
  ASSERT_TRUE(decoder);
  // Frames are 100 ms apart, whatever the bursts in which they arrive.
  const auto messages = decode_at(**decoder, bytes, 35000.0, 4000);
  ASSERT_GT(messages.size(), 50U);
  EXPECT_EQ(messages.size(), (*decoder)->status().messages);
  EXPECT_EQ(messages[0].stream->topic, "/radar/points");
  EXPECT_EQ(messages[0].stream->schema, "foxglove.PointCloud");
  std::size_t points = 0;
  for (const DecodedMessage& m : messages) {
    const auto scan = parse_point_cloud(m.json);
    ASSERT_TRUE(scan);
    EXPECT_EQ(scan->time, m.time);
    points += scan->points.size();
  }
  EXPECT_GT(points, 1000U);
}

TEST(DeviceDecoder, LidarRevolutionsAreScans) {
  WAYFARE_NEEDS_RECORDING(path,
                          "devices/rplidar/legacy_scan_bin/living_room_116_steps/frame_0008.bin");
  const std::string bytes = io::read_file(path)->bytes;
  auto decoder = make_decoder({"lidar", "rplidar", 115200, ""});
  const auto messages = decode_at(**decoder, bytes, 10000.0, 333);
  ASSERT_GT(messages.size(), 2U);
  EXPECT_EQ(messages[0].stream->topic, "/lidar/scan");
  for (std::size_t i = 0; i < messages.size(); ++i) {
    const auto scan = parse_laser_scan(messages[i].json);
    ASSERT_TRUE(scan);
    ASSERT_EQ(scan->ranges_m.size(), 360U);
    std::size_t hits = 0;
    for (std::size_t b = 0; b < 360; ++b) hits += scan->returned(b) ? 1 : 0;
    EXPECT_GT(hits, 100U);
    // 300 nodes of 500 µs.
    if (i > 0) {
      EXPECT_NEAR(to_seconds(messages[i].time - messages[i - 1].time), 0.15, 0.03);
    }
  }
}

}  // namespace
}  // namespace wayfare::logger
