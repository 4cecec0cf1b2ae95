// Radar, wheels, gyro and truth in a CARMEN log.

#include <wayfare/io/carmen.hpp>

#include <cmath>
#include <limits>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <wayfare/core/random.hpp>

#include "core/at.hpp"

namespace wayfare::io {
namespace {

using ::testing::HasSubstr;
using tests::at;

RadarPoint random_point(Rng& rng) {
  const auto number = [&] { return static_cast<float>(rng.normal(0.0, 4.0)); };
  return {number(), number(), number(), number(), number()};
}

// Thirds of a second, long decimals, frames without a point.
Recording robot_recording() {
  Rng rng(5);
  Recording run;
  run.wheel_base_m = 0.16;
  run.radar_max_speed_m_s = 0.9736;
  run.T_base_radar = Transform2<frame::Base, frame::Radar>(SE2d(0.07, -0.01, Angle::degrees(1.5)));
  for (int i = 0; i < 40; ++i) {
    const LogTime time = LogTime::from_nanoseconds(1'000'000'001 + i * 333'333'333LL);
    const SE2d pose(rng.normal(), rng.normal(), Angle::radians(rng.uniform(-3.1, 3.1)));
    run.odometry.push_back({time, Transform2<frame::Odom, frame::Base>(pose)});
    run.wheels.push_back({time, rng.normal(), rng.normal()});
    run.gyro.push_back({time, rng.normal()});
    run.truth.push_back({time + Duration(7), Transform2<frame::Map, frame::Base>(pose)});
    RadarScan scan{time + Duration(11), {}};
    for (int k = 0; k < i % 4; ++k) scan.points.push_back(random_point(rng));
    run.radar.push_back(scan);
    run.scans.push_back({time + Duration(13), Angle::degrees(-180), Angle::degrees(1), 0.05F, 3.5F,
                         std::vector<float>(360, 1.0F + 0.01F * static_cast<float>(i))});
  }
  return run;
}

TEST(RobotLog, ReadsBackToTheSameBits) {
  const Recording run = robot_recording();
  const auto log = parse_carmen(format_carmen(run), "log");
  ASSERT_TRUE(log.has_value()) << log.error().to_string();
  EXPECT_TRUE(log->problems.empty());
  const Recording& read = log->recording;
  ASSERT_EQ(read.wheels.size(), run.wheels.size());
  ASSERT_EQ(read.gyro.size(), run.gyro.size());
  ASSERT_EQ(read.truth.size(), run.truth.size());
  ASSERT_EQ(read.radar.size(), run.radar.size());
  ASSERT_EQ(read.scans.size(), run.scans.size());
  for (std::size_t i = 0; i < run.wheels.size(); ++i) {
    EXPECT_EQ(read.wheels[i].time, run.wheels[i].time);
    EXPECT_EQ(read.wheels[i].left_m, run.wheels[i].left_m);
    EXPECT_EQ(read.wheels[i].right_m, run.wheels[i].right_m);
    EXPECT_EQ(read.gyro[i].time, run.gyro[i].time);
    EXPECT_EQ(read.gyro[i].turn_rate_rad_s, run.gyro[i].turn_rate_rad_s);
    EXPECT_EQ(read.truth[i].time, run.truth[i].time);
    const SE2d &a = run.truth[i].T_map_base.raw(), &b = read.truth[i].T_map_base.raw();
    EXPECT_EQ(b.translation(), a.translation());
    EXPECT_NEAR((a.inverse() * b).heading().radians(), 0.0, 1e-15);
    EXPECT_EQ(read.radar[i].time, run.radar[i].time);
    EXPECT_EQ(read.radar[i].points, run.radar[i].points);
    EXPECT_EQ(read.scans[i].ranges_m, run.scans[i].ranges_m);
  }
  EXPECT_EQ(read.wheel_base_m, run.wheel_base_m);
  EXPECT_EQ(read.radar_max_speed_m_s, run.radar_max_speed_m_s);
  EXPECT_LT(read.T_base_radar.raw().minus(run.T_base_radar.raw()).norm(), 1e-12);
  EXPECT_EQ(log->statistics.radar_points, 40U / 4U * (0 + 1 + 2 + 3));
}

TEST(RobotLog, LinesAreInOrderOfTime) {
  const std::string text = format_carmen(robot_recording());
  LogTime last;
  std::size_t lines = 0;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = text.find('\n', begin);
    const std::string line = text.substr(begin, end - begin);
    begin = end + 1;
    if (line[0] == '#' || line.starts_with("PARAM")) continue;
    const std::size_t stamp = line.rfind(' ');
    const LogTime time = at(std::stod(line.substr(stamp)));
    EXPECT_GE(time, last) << line;
    last = time;
    ++lines;
  }
  EXPECT_EQ(lines, 6U * 40U);
}

TEST(RobotLog, OldReadersReadTheSameScansAndOdometry) {
  const Recording run = robot_recording();
  Recording plain;
  plain.scans = run.scans;
  plain.odometry = run.odometry;
  const auto a = parse_carmen(format_carmen(run), "all"),
             b = parse_carmen(format_carmen(plain), "b");
  ASSERT_TRUE(a.has_value() && b.has_value());
  EXPECT_EQ(format_carmen({{}, a->recording.scans, a->recording.odometry}),
            format_carmen({{}, b->recording.scans, b->recording.odometry}));
}

CarmenLog radar_only(const std::string& text) {
  CarmenOptions options;
  options.needs_laser = false;
  auto log = parse_carmen(text, "log", options);
  EXPECT_TRUE(log.has_value()) << log.error().to_string();
  return log ? std::move(*log) : CarmenLog{};
}

TEST(RobotLog, ALogWithoutLaserIsReadIfAllowed) {
  const std::string text = "RADAR 1 1 2 0 -0.5 13.2 7.5 host 7.5\nWHEELS 0.1 0.2 7.6 host 7.6\n";
  const auto refused = parse_carmen(text, "log");
  ASSERT_FALSE(refused.has_value());
  EXPECT_THAT(refused.error().message, HasSubstr("no usable laser scan"));
  const CarmenLog log = radar_only(text);
  ASSERT_EQ(log.recording.radar.size(), 1U);
  EXPECT_EQ(log.recording.radar[0].points[0], (RadarPoint{1.0F, 2.0F, 0.0F, -0.5F, 13.2F}));
  ASSERT_EQ(log.recording.wheels.size(), 1U);
  const auto nothing = parse_carmen("# nothing\n", "log", {.needs_laser = false});
  ASSERT_FALSE(nothing.has_value());
  EXPECT_THAT(nothing.error().message, HasSubstr("no line of a robot's log"));
}

struct BadLine {
  std::string line, message;
};

// A bad line between good ones: only the bad one is dropped and reported.
TEST(RobotLog, AMalformedLineAffectsOnlyItself) {
  const std::string most = std::to_string(std::numeric_limits<std::size_t>::max());
  const BadLine bad[] = {
      {"RADAR", "expected the number of points"},
      {"RADAR -1 2.0 h 2.0", "expected the number of points"},
      {"RADAR 2 1 2 0 0 9 2.0 h 2.0", "point 2 of 2"},
      {"RADAR " + most + " 1 2 0 0 9 2.0 h 2.0", "point 2 of " + most},
      {"RADAR 1 1 x 0 0 9 2.0 h 2.0", "not a number: 'x'"},
      {"RADAR 0 1 2 0 0 9 2.0 h 2.0", "more fields"},
      {"RADAR 1 1 2 0 0 9", "ends before the time stamp"},
      {"WHEELS 1", "ends where left and right wheel"},
      {"WHEELS nan 1 2.0 h 2.0", "not finite"},
      {"GYRO x 2.0 h 2.0", "turn rate: not a number"},
      {"GYRO 0.1", "ends before the time stamp"},
      {"TRUEPOS 1 2 3 2.0 h 2.0", "not a number: 'h'"},
  };
  const std::string good = "RADAR 1 1 2 0 0 9 1.0 h 1.0\n",
                    after = "RADAR 1 1 2 0 0 9 3.0 h 3.0\nWHEELS 0 0 3.0 h 3.0\n";
  for (const BadLine& b : bad) {
    const CarmenLog log = radar_only(good + b.line + "\n" + after);
    ASSERT_EQ(log.problems.count(), 1U) << b.line;
    EXPECT_EQ(log.problems.first()[0].line, 2U);
    EXPECT_THAT(log.problems.first()[0].to_string(), HasSubstr(b.message)) << b.line;
    EXPECT_EQ(log.recording.radar.size(), 2U) << b.line;
    EXPECT_EQ(log.recording.wheels.size(), 1U) << b.line;
  }
}

TEST(RobotLog, NonFinitePointsAreDropped) {
  const CarmenLog log = radar_only("RADAR 3 nan 2 0 0 9 1 2 0 0 9 1 2 0 1.#INF 9 1.0 h 1.0\n");
  ASSERT_EQ(log.recording.radar.size(), 1U);
  EXPECT_EQ(log.recording.radar[0].points.size(), 1U);
  EXPECT_EQ(log.statistics.invalid_points, 2U);
  ASSERT_EQ(log.problems.count(), 1U);
  EXPECT_THAT(log.problems.first()[0].message, HasSubstr("2 radar points"));
}

TEST(RobotLog, DuplicateAndLateLinesAreDroppedAndReported) {
  const CarmenLog log = radar_only(
      "WHEELS 0.1 0.1 1.0 h 1.0\nWHEELS 0.1 0.1 1.0 h 1.0\n"
      "RADAR 0 1.0 h 1.0\nRADAR 0 1.1 h 1.1\nRADAR 0 0.5 h 0.5\nRADAR 0 1.2 h 1.2\n"
      "GYRO 0.1 1.0 h 1.0\nGYRO 0.2 1.0 h 1.0\n");
  EXPECT_EQ(log.recording.wheels.size(), 1U);
  EXPECT_EQ(log.recording.radar.size(), 3U);
  EXPECT_EQ(log.recording.gyro.size(), 1U);
  ASSERT_EQ(log.problems.count(), 3U);
  EXPECT_EQ(log.problems.first()[0].line, 5U);
  EXPECT_THAT(log.problems.first()[0].message, HasSubstr("radar scan is out of order"));
  EXPECT_EQ(log.problems.first()[1].line, 2U);
  EXPECT_THAT(log.problems.first()[1].message, HasSubstr("repeats the wheel sample of line 1"));
  EXPECT_EQ(log.problems.first()[2].line, 8U);
}

}  // namespace
}  // namespace wayfare::io
