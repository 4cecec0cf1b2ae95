// Decoding of a device's bytes to stamped messages.
#include <wayfare/logger/device_decoder.hpp>

#include <algorithm>
#include <limits>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include <wayfare/decode/rplidar_scan.hpp>
#include <wayfare/decode/rplidar_stream.hpp>
#include <wayfare/decode/stream_decoder.hpp>
#include <wayfare/io/text_file.hpp>
#include <wayfare/logger/device_messages.hpp>
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

/// Those of one topic.
std::vector<DecodedMessage> of_topic(const std::vector<DecodedMessage>& all,
                                     const std::string& topic) {
  std::vector<DecodedMessage> some;
  for (const DecodedMessage& m : all)
    if (m.stream->topic == topic) some.push_back(m);
  return some;
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
  const auto all = decode_at(**decoder, bytes, 35000.0, 4000);
  const auto messages = of_topic(all, "/radar/points");
  ASSERT_GT(messages.size(), 50U);
  EXPECT_EQ(messages.size(), (*decoder)->status().messages);
  EXPECT_EQ(messages[0].stream->schema, "foxglove.PointCloud");
  EXPECT_THAT(messages[0].json, HasSubstr(R"("name":"noise")"));
  // Each frame also with its profile, statistics and temperatures.
  const auto frames = of_topic(all, "/radar/frame");
  ASSERT_EQ(frames.size(), messages.size());
  std::size_t i = 0;
  for (const DecodedMessage& m : frames) {
    const auto frame = parse_radar_frame(m.json);
    ASSERT_TRUE(frame);
    EXPECT_EQ(frame->time, messages[i].time);
    EXPECT_EQ(frame->points, parse_point_cloud(messages[i++].json)->points.size());
    EXPECT_EQ(frame->range_profile.size(), 256U);
    ASSERT_TRUE(frame->statistics && frame->temperature);
    EXPECT_GT(frame->statistics->transmit_us, 10'000U);
    EXPECT_GT(frame->temperature->celsius[0], 10);
  }
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
  const auto all = decode_at(**decoder, bytes, 10000.0, 333);
  const auto messages = of_topic(all, "/lidar/scan"), nodes = of_topic(all, "/lidar/nodes");
  ASSERT_GT(messages.size(), 2U);
  ASSERT_EQ(nodes.size(), messages.size());
  for (std::size_t i = 0; i < messages.size(); ++i) {
    const auto scan = parse_laser_scan(messages[i].json);
    ASSERT_TRUE(scan);
    ASSERT_EQ(scan->ranges_m.size(), 360U);
    std::size_t hits = 0;
    for (std::size_t b = 0; b < 360; ++b) hits += scan->returned(b) ? 1 : 0;
    EXPECT_GT(hits, 100U);
    // A beam has the quality of its point, the nearest of the nodes in its sector.
    const auto json = nlohmann::json::parse(messages[i].json);
    ASSERT_EQ(json["intensities"].size(), 360U);
    const auto points = parse_lidar_nodes(nodes[i].json);
    ASSERT_TRUE(points);
    EXPECT_GT(points->size(), 250U);
    std::size_t bright = 0;
    for (std::size_t b = 0; b < 360; ++b) {
      const auto quality = json["intensities"][b].get<int>();
      bright += quality > 0 ? 1 : 0;
      EXPECT_TRUE(scan->returned(b) || quality == 0) << b;
      if (!scan->returned(b)) continue;
      const bool found = std::any_of(points->begin(), points->end(), [&](const auto& p) {
        return static_cast<float>(p.point.distance_m()) == scan->ranges_m[b] &&
               p.point.quality == quality;
      });
      EXPECT_TRUE(found) << b;
    }
    EXPECT_GT(bright, 100U);
    // 300 nodes of 500 µs.
    if (i > 0) {
      EXPECT_NEAR(to_seconds(messages[i].time - messages[i - 1].time), 0.15, 0.03);
    }
  }
}

TEST(DeviceDecoder, AnXsensUnitsStateIsKept) {
  WAYFARE_NEEDS_RECORDING(path, "devices/xsens/mti_mtdata2/einride_testdata/1/output.bin");
  const std::string bytes = io::read_file(path)->bytes;
  auto decoder = make_decoder({"imu", "xsens", 115200, ""});
  const auto all = decode_at(**decoder, bytes, 11520.0, 500);
  const auto samples = of_topic(all, "/imu/imu"), states = of_topic(all, "/imu/state");
  EXPECT_GT(samples.size(), 10U);
  ASSERT_GT(states.size(), 10U);
  std::size_t oriented = 0, located = 0;
  for (const DecodedMessage& m : states) {
    const auto state = parse_mt_state(m.json);
    ASSERT_TRUE(state) << m.json;
    EXPECT_EQ(state->time, m.time);
    oriented += state->sample.quaternion || state->sample.euler_deg ? 1 : 0;
    located += state->sample.lat_lon_deg && state->sample.velocity_mps ? 1 : 0;
    EXPECT_FALSE(state->sample.acceleration_mps2);
  }
  EXPECT_GT(oriented, 10U);
  EXPECT_GT(located, 0U);
}

TEST(DeviceDecoder, TellsWhyARadarsFramesAreRefused) {
  auto decoder = make_decoder({"radar", "ti_mmwave", 921600, ""});
  std::string bytes(reinterpret_cast<const char*>(decode::kTiMagic.data()), 8);
  bytes.append(64, '\x7F');
  EXPECT_TRUE(decode_at(**decoder, bytes, 35000.0, 100).empty());
  (*decoder)->feed({}, start(), [](const DecodedMessage&) {});
  EXPECT_THAT((*decoder)->status().sample, HasSubstr("of no known header"));
}

}  // namespace
}  // namespace wayfare::logger
