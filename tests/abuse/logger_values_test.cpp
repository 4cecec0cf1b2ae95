// Messages, status lines and decoders of devices at their edges.
#include <array>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include <wayfare/core/random.hpp>
#include <wayfare/logger/device_decoder.hpp>
#include <wayfare/logger/logger.hpp>
#include <wayfare/logger/messages.hpp>

#include "abuse/abuse.hpp"
#include "abuse/decode_streams.hpp"

namespace wayfare::logger {
namespace {

using namespace std::chrono_literals;
using tests::in_two_threads;
using tests::kNotFinite;
using tests::Stream;

constexpr std::int64_t kEarliest = std::numeric_limits<std::int64_t>::min();
constexpr std::int64_t kLatest = std::numeric_limits<std::int64_t>::max();

// ---- messages ----

TEST(MessagesAbuse, TimesAtTheirLimits) {
  for (const std::int64_t ns :
       {std::int64_t{0}, std::int64_t{-1}, std::int64_t{-1'000'000'000}, std::int64_t{-999'999'999},
        std::int64_t{1'000'000'000'000'000'000}, std::int64_t{-8'999'999'999'999'999'999}}) {
    const LogTime time = LogTime::from_nanoseconds(ns);
    const auto scan = parse_laser_scan(laser_scan_json({time, {}, {}, 0, 1, {1.0F}}, "a"));
    ASSERT_TRUE(scan) << ns;
    EXPECT_EQ(scan->time, time);
    EXPECT_EQ(parse_point_cloud(point_cloud_json({time, {}}, "a"))->time, time);
    EXPECT_EQ(parse_imu(imu_json({.time = time, .angular_rate_radps = {1, 2, 3}}, "a"))->time,
              time);
  }
  // Beyond what is read back, but written as it is.
  const std::string first = imu_json({LogTime::from_nanoseconds(kEarliest)}, "a");
  EXPECT_NE(first.find(R"("sec":-9223372037,"nsec":145224192)"), first.npos) << first;
  EXPECT_FALSE(parse_imu(first));
  const std::string last = imu_json({LogTime::from_nanoseconds(kLatest)}, "a");
  EXPECT_NE(last.find(R"("sec":9223372036,"nsec":854775807)"), last.npos) << last;
  EXPECT_FALSE(parse_imu(last));
}

std::string imu_at(const std::string& sec, const std::string& nsec) {
  return R"({"timestamp":{"sec":)" + sec + R"(,"nsec":)" + nsec + R"(},"angular_velocity":null})";
}

TEST(MessagesAbuse, TimesThatAreNoTimesAreRefused) {
  EXPECT_TRUE(parse_imu(imu_at("5", "7")));
  for (const char* sec : {"18446744073709551615", "9223372036854775808", "9223372036854775807",
                          "-9223372036854775808", "9000000001", "1.5", "1e3", "\"5\"", "null", "[]",
                          "{}", "1e999", "99999999999999999999999"})
    EXPECT_FALSE(parse_imu(imu_at(sec, "0"))) << sec;
  for (const char* nsec : {"1000000000", "-1", "18446744073709551615", "0.5", "null"})
    EXPECT_FALSE(parse_imu(imu_at("0", nsec))) << nsec;
}

TEST(MessagesAbuse, EmptyAndOneAndNotFinite) {
  const LogTime time = LogTime::from_seconds(1e9);
  for (const std::size_t n : {0U, 1U, 2U}) {
    const LaserScan scan{time, Angle::radians(1.0),        Angle::radians(0.5), 0.0F,
                         1.0F, std::vector<float>(n, 0.5F)};
    const auto back = parse_laser_scan(laser_scan_json(scan, ""));
    ASSERT_TRUE(back);
    EXPECT_EQ(back->ranges_m, scan.ranges_m);
    EXPECT_EQ(back->first_bearing.radians(), 1.0);
  }
  for (const double bad : kNotFinite) {
    const auto f = static_cast<float>(bad);
    const auto scan = parse_laser_scan(laser_scan_json({time, {}, {}, 0, 1, {f, 2.0F}}, "a"));
    ASSERT_TRUE(scan);
    EXPECT_TRUE(std::isnan(scan->ranges_m[0])) << "no return";
    EXPECT_EQ(scan->ranges_m[1], 2.0F);
    const LaserScan bearing{time, Angle::radians(bad), {}, 0, 1, {1.0F}};
    EXPECT_FALSE(parse_laser_scan(laser_scan_json(bearing, "a")));
    const auto cloud = parse_point_cloud(point_cloud_json({time, {{f, 1, 2, 3, 4}}}, "a"));
    ASSERT_TRUE(cloud);
    EXPECT_FALSE(std::isfinite(cloud->points.at(0).x_m));
    const auto imu = parse_imu(imu_json(
        {.time = time, .angular_rate_radps = {bad, 0, 0}, .specific_force_mps2 = {1, 2, 3}}, "a"));
    ASSERT_TRUE(imu);
    EXPECT_TRUE(imu->angular_rate_radps.array().isNaN().all());
    EXPECT_EQ(imu->specific_force_mps2, Eigen::Vector3d(1, 2, 3));
  }
}

TEST(MessagesAbuse, TextsThatAreNoMessages) {
  const std::string deep(200'000, '[');
  std::string nested;
  for (int i = 0; i < 50'000; ++i) nested += R"({"a":)";
  nested += "1" + std::string(50'000, '}');
  const std::string time = R"({"timestamp":{"sec":1,"nsec":1},)";
  for (const std::string& text :
       {std::string(), std::string("null"), std::string("1"), std::string("[]"), std::string("{}"),
        std::string(3, '\0'), deep, nested, time + R"("ranges":1,"start_angle":0,"end_angle":0})",
        time + R"("ranges":[[]],"start_angle":0,"end_angle":0})",
        time + R"("angular_velocity":[1,2,3]})", time + R"("angular_velocity":{"x":1,"y":2}})",
        time + R"("point_stride":1e300,"fields":[],"data":""})",
        time + R"("point_stride":20,"fields":[1,null,{"name":"x"}],"data":"AAAA"})",
        time + R"("point_stride":20,"fields":[],"data":"A A"})"}) {
    EXPECT_FALSE(parse_laser_scan(text)) << text.substr(0, 80);
    EXPECT_FALSE(parse_point_cloud(text)) << text.substr(0, 80);
    EXPECT_FALSE(parse_imu(text)) << text.substr(0, 80);
  }
}

TEST(MessagesAbuse, RecordingsThatAreNone) {
  EXPECT_FALSE(read_marg_recording(""));
  EXPECT_FALSE(read_robot_recording("/"));
  EXPECT_FALSE(read_marg_recording("/dev/null"));
  EXPECT_FALSE(is_recording(""));
  EXPECT_FALSE(is_recording(".mcap"));
  EXPECT_EQ(json_escaped(""), "");
  EXPECT_EQ(json_escaped(std::string_view("\0\x7f", 2)), "\\u0000\\u007f");
}

// ---- status ----

TEST(StatusAbuse, AnyNumberIsJson) {
  LoggerStatus status;
  status.sensors.resize(1);
  for (const double value : {0.0, -0.0, 0.04, 1.99, -1.99, 1e9, 1e300, 1.7976931348623157e308,
                             -1e300, tests::kTiny, tests::kNan, tests::kInf, -tests::kInf}) {
    status.seconds = status.sensors[0].bytes_per_s = value;
    const std::string json = to_json(status);
    const std::size_t at = json.find("\"seconds\":") + 10;
    const std::string number = json.substr(at, json.find(',', at) - at);
    ASSERT_EQ(number.find_first_not_of("-0123456789."), number.npos) << number;
    ASSERT_EQ(number.size() - number.find('.'), 2U) << "one decimal";
    const double expected = std::isfinite(value) ? value : 0.0;
    EXPECT_NEAR(std::stod(number), expected, 0.1 + 1e-15 * std::abs(expected));
  }
}

TEST(StatusAbuse, TimesBeforeTheEpoch) {
  LoggerStatus status;
  status.time = LogTime::from_nanoseconds(-1);
  EXPECT_NE(to_json(status).find(R"("sec":-1,"nsec":999999999)"), std::string::npos);
  status.time = LogTime::from_nanoseconds(kEarliest);
  EXPECT_NE(to_json(status).find(R"("sec":-9223372037,"nsec":145224192)"), std::string::npos);
}

TEST(StatusAbuse, AnyTextSurvivesItsLine) {
  Rng rng(1);
  for (int trial = 0; trial < 500; ++trial) {
    LoggerStatus status;
    std::string name(rng.below(30), ' ');
    for (char& c : name) c = static_cast<char>(rng());
    status.file = status.error = name;
    const std::string json = to_json(status), line = status_line(json);
    ASSERT_EQ(line.find('\n'), line.size() - 1) << "one line whatever the names";
    ASSERT_EQ(status_of_line(line), json);
    std::string noise(rng.below(40), ' ');
    for (char& c : noise) c = static_cast<char>(rng());
    static_cast<void>(status_of_line(noise));
  }
  EXPECT_EQ(status_of_line(status_line("")), "");
  EXPECT_FALSE(status_of_line("*"));
  EXPECT_FALSE(status_of_line("\r\n"));
}

// ---- decoders of devices ----

TEST(DeviceDecoderAbuse, WithoutARateThereIsNoDecoder) {
  for (const std::string& kind : device_kinds())
    for (const int baud : {0, -1, std::numeric_limits<int>::min()}) {
      const auto decoder = make_decoder({"a", kind, baud, ""});
      ASSERT_FALSE(decoder);
      EXPECT_EQ(decoder.error().code, ErrorCode::invalid);
    }
}

/// Streams of a device of that kind.
Stream stream_of(const std::string& kind, Rng& rng) {
  if (kind == "ti_mmwave") return tests::ti_stream(rng, 10);
  if (kind == "rplidar") return tests::rplidar_stream(rng, 8);
  return tests::xbus_stream(rng, 20);
}

TEST(DeviceDecoderAbuse, NothingAndNoiseAndTwoThreads) {
  for (const std::string& kind : device_kinds()) {
    const auto both = in_two_threads([&](int) {
      Rng rng(2);
      const auto decoder = std::move(*make_decoder({"name\"\n/", kind, 1, ""}));
      std::string all;
      const auto sink = [&](const DecodedMessage& m) { all += m.stream->topic + m.json; };
      decoder->feed({}, LogTime{}, sink);
      EXPECT_EQ(decoder->status().messages, 0U);
      for (int i = 0; i < 30; ++i) {
        Stream bytes = stream_of(kind, rng);
        if (i % 3 == 0)
          for (auto& byte : bytes) byte = static_cast<std::uint8_t>(rng());
        // Times of arrival in any order.
        decoder->feed(bytes, LogTime::from_seconds(rng.uniform(-1e9, 1e9)), sink);
      }
      return all + std::to_string(decoder->status().skipped_bytes);
    });
    EXPECT_EQ(both[0], both[1]) << kind;
  }
}

/// A station's snapshot of a tracker, as a message.
Stream snapshot_message(std::uint32_t device, std::uint32_t frame) {
  Stream data = {0xC8, 0x10, 46};
  data.resize(49);
  decode::store_be(device, &data[3]);
  decode::store_be(frame, &data[7]);
  return tests::xbus_message(0x36, data);
}

TEST(DeviceDecoderAbuse, FrameNumbersThatWanderDoNotOverflow) {
  const auto decoder = std::move(*make_decoder({"suit", "xsens", 921600, ""}));
  std::uint64_t messages = 0;
  LogTime now = LogTime::from_seconds(1.7e9);
  const auto sink = [&](const DecodedMessage& m) {
    ++messages;
    EXPECT_LE(m.time, now) << "measured before it arrived";
  };
  Stream configuration(98);
  decode::store_be(std::uint16_t{0xFFFF}, &configuration[4]);  // the longest period
  for (const std::uint32_t step : {0x7FFFFFFFU, 0x80000001U, 1U, 0x70000000U, 0x90000000U}) {
    decoder->feed(tests::xbus_message(0x0D, configuration), now, sink);
    std::uint32_t frame = 0;
    for (int i = 0; i < 40; ++i) {
      frame += step;
      for (std::uint32_t k = 0; k < 3; ++k)
        decoder->feed(snapshot_message(7, frame + k), now += 10ms, sink);
    }
  }
  EXPECT_GT(messages, 100U);
}

/// 2³¹ ticks of 100 µs a message are 2⁶³ ns after 43 000 messages.
TEST(DeviceDecoderAbuse, SampleTimesThatWanderDoNotOverflow) {
  const auto decoder = std::move(*make_decoder({"unit", "xsens", 921600, ""}));
  std::uint64_t messages = 0;
  LogTime now = LogTime::from_seconds(1.7e9);
  // A larger offset from the line of its clock is taken for a restart of the device.
  const Duration most = ClockEnvelopeOptions().jump + 1ms;
  const auto sink = [&](const DecodedMessage& m) {
    ++messages;
    ASSERT_TRUE(m.time <= now && m.time >= now - most) << messages;
  };
  Stream data = {0x10, 0x60, 4, 0, 0, 0, 0, 0x80, 0x20, 12};  // sample time, rate of turn
  data.resize(data.size() + 12);
  for (std::uint32_t ticks = 0; messages < 44'000; ticks += 0x7FFFFFFF) {
    decode::store_be(ticks, &data[3]);
    decoder->feed(tests::xbus_message(0x36, data), now += 10ms, sink);
    ASSERT_FALSE(HasFatalFailure());
  }
}

TEST(DeviceDecoderAbuse, MoreTrackersThanAStationHas) {
  const auto decoder = std::move(*make_decoder({"suit", "xsens", 921600, ""}));
  std::map<std::string, int> messages;  // of a topic
  for (std::uint32_t device = 0; device < 1000; ++device)
    for (std::uint32_t frame = 0; frame < 2; ++frame)
      decoder->feed(snapshot_message(device, frame), LogTime::from_seconds(1.0),
                    [&](const DecodedMessage& m) { ++messages[m.stream->topic]; });
  // Of each of 32 trackers the state of both frames, and the increments from one to the next.
  EXPECT_EQ(messages.size(), 2 * 32U);
  for (const auto& [topic, count] : messages) EXPECT_EQ(count, topic.ends_with("imu") ? 1 : 2);
}

}  // namespace
}  // namespace wayfare::logger
