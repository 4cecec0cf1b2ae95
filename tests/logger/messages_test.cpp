// Measurements to JSON and back, bit by bit.
#include <wayfare/logger/messages.hpp>

#include <cmath>
#include <limits>
#include <random>
#include <string>

#include "io/support.hpp"
#include "logger/damaged_text.hpp"

namespace wayfare::logger {
namespace {

using ::testing::HasSubstr;

LogTime some_time() { return LogTime::from_nanoseconds(1'700'000'000'123'456'789); }

//! [message]
TEST(Messages, LaserScan) {
  LaserScan scan{some_time(), Angle::degrees(-180.0), Angle::degrees(1.0), 0.15F, 12.0F, {}};
  std::mt19937 random(1);
  for (int i = 0; i < 360; ++i)
    scan.ranges_m.push_back(i % 7 == 0 ? std::numeric_limits<float>::quiet_NaN()
                                       : 0.2F + static_cast<float>(random()) * 1e-9F);
  const std::string json = laser_scan_json(scan, "lidar");
  EXPECT_THAT(json, HasSubstr(R"("timestamp":{"sec":1700000000,"nsec":123456789})"));
  EXPECT_THAT(json, HasSubstr(R"("frame_id":"lidar")"));
  const auto back = parse_laser_scan(json);
  ASSERT_TRUE(back);
  EXPECT_EQ(back->time, scan.time);
  EXPECT_EQ(back->min_range_m, scan.min_range_m);
  EXPECT_EQ(back->max_range_m, scan.max_range_m);
  ASSERT_EQ(back->ranges_m.size(), scan.ranges_m.size());
  for (std::size_t i = 0; i < scan.ranges_m.size(); ++i) {
    EXPECT_EQ(std::isnan(back->ranges_m[i]), i % 7 == 0);
    if (i % 7 != 0) {
      EXPECT_EQ(back->ranges_m[i], scan.ranges_m[i]);
    }
    EXPECT_NEAR(std::remainder((back->bearing(i) - scan.bearing(i)).radians(), 2.0 * M_PI), 0.0,
                1e-12);
  }
}
//! [message]

TEST(Messages, AScanKeepsTheTimesOfItsBeams) {
  LaserScan scan{some_time(), Angle::degrees(-180.0), Angle::degrees(1.0), 0.15F, 12.0F, {}};
  scan.ranges_m.assign(361, 1.0F);
  EXPECT_EQ(laser_scan_json(scan, "lidar").find("time_increment"), std::string::npos);
  for (const std::int64_t ns : {505'051, -506'963, 1, 0}) {
    scan.time_increment = Duration(ns);
    const auto back = parse_laser_scan(laser_scan_json(scan, "lidar"));
    ASSERT_TRUE(back);
    EXPECT_EQ(back->time_increment, scan.time_increment);
  }
}

TEST(Messages, PointCloud) {
  for (const std::size_t n : {0U, 1U, 2U, 3U, 57U}) {
    RadarScan scan{some_time(), {}};
    std::mt19937 random(2);
    const auto number = [&] { return static_cast<float>(random()) * 1e-9F - 2.0F; };
    for (std::size_t i = 0; i < n; ++i)
      scan.points.push_back({number(), number(), number(), number(), number()});
    const auto back = parse_point_cloud(point_cloud_json(scan, "radar"));
    ASSERT_TRUE(back);
    EXPECT_EQ(back->time, scan.time);
    EXPECT_EQ(back->points, scan.points);
  }
}

TEST(Messages, PointCloudDataIsBase64OfLittleEndianFloats) {
  const RadarScan scan{some_time(), {{1.0F, -2.0F, 0.0F, 0.5F, 13.0F}}};
  // 0000803f 000000c0 00000000 0000003f 00005041 in base64 (RFC 4648).
  EXPECT_THAT(point_cloud_json(scan, "r"), HasSubstr(R"("data":"AACAPwAAAMAAAAAAAAAAPwAAUEE=")"));
}

TEST(Messages, Imu) {
  MargSample sample{some_time(), {0.1, -0.2, 1.0 / 3.0}, {0.0, 0.0, 9.80665}, {20.0, 0.0, 43.0}};
  const auto back = parse_imu(imu_json(sample, "imu"));
  ASSERT_TRUE(back);
  EXPECT_EQ(back->time, sample.time);
  EXPECT_EQ(back->angular_rate_radps, sample.angular_rate_radps);
  EXPECT_EQ(back->specific_force_mps2, sample.specific_force_mps2);
  EXPECT_EQ(back->magnetic_field_uT, sample.magnetic_field_uT);
  sample.magnetic_field_uT.setConstant(MargSample::kNone);
  const std::string json = imu_json(sample, "imu");
  EXPECT_THAT(json, HasSubstr(R"("magnetic_field":null)"));
  EXPECT_TRUE(std::isnan(parse_imu(json)->magnetic_field_uT.x()));
}

TEST(Messages, InvalidMessagesAreErrors) {
  LaserScan scan{some_time(), {}, Angle::degrees(1.0), 0.1F, 5.0F, {1.0F, 2.0F}};
  const std::string good[] = {
      laser_scan_json(scan, "a"),
      point_cloud_json({some_time(), {{1.0F, 2.0F, 3.0F, 4.0F, 5.0F}}}, "a"),
      imu_json({some_time(), {1, 2, 3}, {4, 5, 6}, {7, 8, 9}}, "a")};
  EXPECT_FALSE(parse_laser_scan(good[1]));
  EXPECT_FALSE(parse_point_cloud(good[0]));
  std::mt19937 random(3);
  for (const std::string& text : good) {
    for (int i = 0; i < 3000; ++i) {
      const std::string damaged = wayfare::testing::damaged(text, i, random);
      // Any result is valid, but the call must return.
      const auto cloud = parse_point_cloud(damaged);
      ASSERT_TRUE(!cloud || cloud->points.size() < 100);
      static_cast<void>(parse_laser_scan(damaged));
      static_cast<void>(parse_imu(damaged));
    }
  }
}

TEST(Messages, NamesAreEscaped) {
  EXPECT_EQ(json_escaped("a\"b\\c\n\xff"), R"(a\"b\\c\u000a\u00ff)");
}

}  // namespace
}  // namespace wayfare::logger
