// All that a device sends as messages, and back, bit by bit.
#include <wayfare/logger/device_messages.hpp>

#include <cmath>
#include <limits>
#include <random>

#include <nlohmann/json.hpp>

#include "decode/ti_streams.hpp"
#include "decode/xbus_streams.hpp"
#include "logger/damaged_text.hpp"

namespace wayfare::logger {
namespace {

using decode::TimedRplidarPoint;
using ::testing::HasSubstr;

LogTime recorded_at() { return LogTime::from_nanoseconds(1'700'000'000'123'456'789); }

TEST(DeviceMessages, EveryNodeOfARevolution) {
  std::mt19937 random(1);
  std::vector<TimedRplidarPoint> points;
  for (int i = 0; i < 500; ++i) {
    decode::RplidarPoint p;
    p.angle_q6 = static_cast<std::uint16_t>(random() % (360 * 64));
    p.angle_rest_q13 = static_cast<std::uint8_t>(random() % 128);
    p.distance_q2 = static_cast<std::uint32_t>(random());
    p.quality = static_cast<std::uint8_t>(random());
    p.start_of_revolution = i == 0;
    points.push_back({p, recorded_at() + Duration(i * 250'123)});
  }
  points[1].point.angle_q6 = 360 * 64 - 1;
  points[1].point.angle_rest_q13 = 127;
  const auto back = parse_lidar_nodes(lidar_nodes_json(points, "lidar"));
  ASSERT_TRUE(back);
  ASSERT_EQ(back->size(), points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    EXPECT_EQ((*back)[i].point, points[i].point) << i;
    EXPECT_EQ((*back)[i].time, points[i].time) << i;
  }
  EXPECT_TRUE(parse_lidar_nodes(lidar_nodes_json({}, "lidar"))->empty());
}

template <class F>
void with_frame(const decode::Stream& bytes, F&& f) {
  int frames = 0;
  decode::each_frame(bytes, [&](const decode::TiFrame& frame) {
    ++frames;
    f(frame);
  });
  EXPECT_EQ(frames, 1);
}

void expect_equal(const RadarFrame& a, const RadarFrame& b) {
  EXPECT_EQ(a.time, b.time);
  EXPECT_EQ(a.number, b.number);
  EXPECT_EQ(a.platform, b.platform);
  EXPECT_EQ(a.points, b.points);
  EXPECT_EQ(a.range_profile, b.range_profile);
  EXPECT_EQ(a.noise_profile, b.noise_profile);
  EXPECT_EQ(a.range_doppler_map, b.range_doppler_map);
  EXPECT_EQ(a.azimuth_map, b.azimuth_map);
  EXPECT_EQ(a.linear_profile, b.linear_profile);
  EXPECT_EQ(a.target_index, b.target_index);
  EXPECT_EQ(a.presence, b.presence);
  ASSERT_EQ(a.targets.size(), b.targets.size());
  EXPECT_EQ(a.statistics.has_value(), b.statistics.has_value());
  EXPECT_EQ(a.temperature.has_value(), b.temperature.has_value());
}

TEST(DeviceMessages, AllOfARadarsFrame) {
  using decode::item_of;
  decode::Item temperature = item_of<std::uint32_t>(9, {0, 4321});
  for (int i = 0; i < 10; ++i)
    decode::append(temperature.payload, static_cast<std::int16_t>(40 - 10 * i));
  const auto bytes = decode::frame(
      77, 0,
      {item_of<std::uint16_t>(2, {1, 60'000, 3}), item_of<std::uint16_t>(3, {4, 5, 6}),
       item_of<std::int16_t>(4, {-7, 8, 9, -32'768}), item_of<std::uint16_t>(5, {10, 65'535}),
       item_of<std::uint32_t>(6, {11, 12, 13, 14, 15, 16}), temperature});
  with_frame(bytes, [](const decode::TiFrame& frame) {
    const RadarFrame sent = radar_frame(frame, recorded_at());
    const std::string json = radar_frame_json(sent, "radar");
    EXPECT_TRUE(nlohmann::json::accept(json)) << json;
    EXPECT_THAT(json, HasSubstr(R"("range_profile":[1,60000,3])"));
    const auto back = parse_radar_frame(json);
    ASSERT_TRUE(back);
    expect_equal(*back, sent);
    EXPECT_EQ(back->number, 77U);
    EXPECT_EQ(back->noise_profile, (std::vector<std::uint16_t>{4, 5, 6}));
    EXPECT_EQ(back->azimuth_map, (std::vector<std::int16_t>{-7, 8, 9, -32'768}));
    EXPECT_EQ(back->range_doppler_map, (std::vector<std::uint16_t>{10, 65'535}));
    EXPECT_EQ(back->statistics->idle_load_percent, 16U);
    EXPECT_TRUE(back->temperature->valid);
    EXPECT_EQ(back->temperature->time_ms, 4321U);
    EXPECT_EQ(back->temperature->celsius[9], -50);
  });
}

TEST(DeviceMessages, TargetsOfPeopleCounting) {
  decode::Item targets{1010, {}};
  decode::append(targets.payload, std::uint32_t{3});
  for (int i = 0; i < 27; ++i) decode::append(targets.payload, 0.1F * static_cast<float>(i));
  const auto bytes = decode::frame(1, 0,
                                   {targets, decode::item_of<std::uint8_t>(1011, {3, 255}),
                                    decode::item_of<std::uint32_t>(1021, {1})});
  with_frame(bytes, [](const decode::TiFrame& frame) {
    const RadarFrame sent = radar_frame(frame, recorded_at());
    const auto back = parse_radar_frame(radar_frame_json(sent, "radar"));
    ASSERT_TRUE(back);
    expect_equal(*back, sent);
    ASSERT_EQ(back->targets.size(), 1U);
    EXPECT_EQ(back->targets[0].id, 3U);
    EXPECT_EQ(back->targets[0].velocity_mps, sent.targets[0].velocity_mps);
    EXPECT_EQ(back->targets[0].confidence, sent.targets[0].confidence);
    EXPECT_EQ(back->presence, true);
  });
}

TEST(DeviceMessages, AnEmptyFrameIsAMessage) {
  with_frame(decode::frame(5, 0, {}), [](const decode::TiFrame& frame) {
    const auto back = parse_radar_frame(radar_frame_json(radar_frame(frame, recorded_at()), "r"));
    ASSERT_TRUE(back);
    EXPECT_EQ(back->number, 5U);
    EXPECT_FALSE(back->statistics);
  });
}

/// A message with every field of another value.
MtState full_state() {
  MtState s;
  s.time = recorded_at();
  decode::MtSample& m = s.sample;
  m.packet_counter = 65'535;
  m.sample_time_fine = 4'294'967'295U;
  m.sample_time_64 = 1ULL << 60;
  m.frame_counter = 12;
  m.itow_ms = 13;
  m.utc = decode::MtUtc{14, 2026, 11, 24, 2, 30, 15, 7};
  m.status_byte = 200;
  m.status_word = 0x80000001U;
  m.temperature_c = 36.6;
  m.pressure_pa = 101'325;
  m.quaternion = Eigen::Vector4d(0.1, -0.2, 1.0 / 3.0, 0.9);
  m.euler_deg = Eigen::Vector3d(-1.5, 2.5, 179.9);
  m.rotation_matrix = Eigen::Matrix3d::Random();
  m.free_acceleration_mps2 = Eigen::Vector3d(1e-9, -2e5, 3.0);
  m.delta_q = Eigen::Vector4d(1.0, 0.0, 1e-7, 0.0);
  m.lat_lon_deg = Eigen::Vector2d(48.123456789, -11.5);
  m.altitude_ellipsoid_m = 500.25;
  m.velocity_mps = Eigen::Vector3d(0.1, 0.2, 0.3);
  m.rssi_dbm = -71;
  m.gnss = decode::MtGnss{};
  m.gnss->longitude_e7_deg = -1'234'567'890;
  m.gnss->satellites = 17;
  m.gnss->velocity_ned_mmps = {1, -2, 3};
  m.gnss->dop_e2 = {1, 2, 3, 4, 5, 6, 65'535};
  m.frame = decode::MtFrame::ned;
  s.satellites = {{0, 11, 41, 0x1F}, {6, 3, 22, 4}};
  s.raw.counts = decode::MtRaw{{1, 2, 3}, {4, 5, 6}, {7, 8, 65'535}, 10};
  s.raw.temperature_c = 25.5;
  s.raw.gyro_temperature_c = Eigen::Vector3d(1, 2, 3);
  return s;
}

TEST(DeviceMessages, AllOfAnXsensUnit) {
  const MtState sent = full_state();
  const std::string json = mt_state_json(sent, "imu");
  EXPECT_TRUE(nlohmann::json::accept(json)) << json;
  const auto back = parse_mt_state(json);
  ASSERT_TRUE(back) << json;
  EXPECT_EQ(mt_state_json(*back, "imu"), json);
  EXPECT_EQ(back->time, sent.time);
  EXPECT_EQ(back->sample.quaternion, sent.sample.quaternion);
  EXPECT_EQ(back->sample.rotation_matrix, sent.sample.rotation_matrix);
  EXPECT_EQ(back->sample.gnss->dop_e2, sent.sample.gnss->dop_e2);
  EXPECT_EQ(back->sample.rssi_dbm, sent.sample.rssi_dbm);
  EXPECT_EQ(back->sample.frame, decode::MtFrame::ned);
  ASSERT_EQ(back->satellites.size(), 2U);
  EXPECT_EQ(back->satellites[1].cn0_dbhz, 22);
  EXPECT_TRUE(sent.has_content());
}

TEST(DeviceMessages, CountersAloneAreNoState) {
  MtState s;
  s.sample.packet_counter = 3;
  s.sample.sample_time_fine = 4;
  EXPECT_FALSE(s.has_content());
  s.sample.pressure_pa = 5;
  EXPECT_TRUE(s.has_content());
}

TEST(DeviceMessages, MountingsAreTransforms) {
  const std::vector<Mounting> sent = {
      {"base_link", "lidar",
       SE3d(Eigen::Vector3d(0.1, -0.2, 0.3), SO3d::exp(Eigen::Vector3d(0.1, 0.2, 3.0)))},
      {"base_link", "ra\"dar", SE3d()}};
  const std::string json = transforms_json(sent, recorded_at());
  EXPECT_TRUE(nlohmann::json::accept(json)) << json;
  EXPECT_TRUE(nlohmann::json::accept(transforms_schema().json));
  const auto back = parse_transforms(json);
  ASSERT_TRUE(back);
  ASSERT_EQ(back->size(), 2U);
  EXPECT_EQ((*back)[1].child, "ra\"dar");
  EXPECT_EQ((*back)[0].pose.translation(), sent[0].pose.translation());
  EXPECT_TRUE(
      (*back)[0].pose.rotation().matrix().isApprox(sent[0].pose.rotation().matrix(), 1e-15));
  EXPECT_FALSE(parse_transforms(R"({"transforms":[{"parent_frame_id":"a"}]})"));
  EXPECT_FALSE(parse_transforms("[]"));
}

TEST(DeviceMessages, SchemasAreJson) {
  for (const MessageSchema& s : {lidar_nodes_schema(), radar_frame_schema(), mt_state_schema()}) {
    EXPECT_TRUE(nlohmann::json::accept(s.json)) << s.json;
    EXPECT_EQ(nlohmann::json::parse(s.json)["title"], s.name);
  }
}

TEST(DeviceMessages, DamagedMessagesAreErrorsOrMessages) {
  const std::vector<TimedRplidarPoint> nodes = {{{640, 4000, 10, true}, recorded_at()}};
  RadarFrame radar;
  radar.range_profile = {1, 2};
  radar.azimuth_map = {3};
  radar.targets.resize(1);
  radar.statistics.emplace();
  const std::string good[] = {
      lidar_nodes_json(nodes, "a"), radar_frame_json(radar, "a"), mt_state_json(full_state(), "a"),
      transforms_json(std::vector<Mounting>{{"a", "b", SE3d()}}, recorded_at())};
  std::mt19937 random(3);
  for (const std::string& text : good) {
    for (int i = 0; i < 2000; ++i) {
      const std::string damaged = wayfare::testing::damaged(text, i, random);
      const auto points = parse_lidar_nodes(damaged);
      ASSERT_TRUE(!points || points->size() < 10);
      static_cast<void>(parse_radar_frame(damaged));
      static_cast<void>(parse_mt_state(damaged));
      static_cast<void>(parse_transforms(damaged));
    }
  }
  for (const char* number : {"-1", "65536", "1.5", "1e30", "\"1\"", "[]", "99999999999999999999"}) {
    const std::string text =
        R"({"timestamp":{"sec":1,"nsec":2},"reference":"ENU","packet_counter":)" +
        std::string(number) + "}";
    EXPECT_FALSE(parse_mt_state(text)) << number;
  }
}

}  // namespace
}  // namespace wayfare::logger
