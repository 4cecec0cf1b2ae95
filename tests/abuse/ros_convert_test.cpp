// Conversion of messages whose numbers are none, out of any use, or contradict each other: refused
// with a reason, or a valid measurement.

#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Eigenvalues>

#include <wayfare/ros/convert.hpp>

#include "abuse/abuse.hpp"

namespace wayfare::ros {
namespace {

const LogTime kNow = LogTime::from_nanoseconds(1'700'000'000'000'000'000);
constexpr float kNanF = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfF = std::numeric_limits<float>::infinity();

template <class T>
void expect_reason(const Result<T>& result) {
  ASSERT_FALSE(result);
  EXPECT_FALSE(result.error().message.empty());
}

TEST(RosConvert, StampsOfAnyNumber) {
  for (const std::int64_t sec : {INT64_MIN, std::int64_t{-1}, std::int64_t{1} << 32U, INT64_MAX})
    expect_reason(time_of({sec, 5}));
  expect_reason(time_of({5, UINT32_MAX}));
  expect_reason(time_of({5, 1'000'000'000}));
  const auto last = time_of({UINT32_MAX, 999'999'999});
  ASSERT_TRUE(last);
  EXPECT_EQ(stamp_of(*last), (Stamp{UINT32_MAX, 999'999'999}));
  EXPECT_DEATH(static_cast<void>(stamp_of(LogTime::from_nanoseconds(-1))), "1970");
}

TEST(RosConvert, ClocksFarApart) {
  const LogTime end = LogTime::from_nanoseconds(INT64_MAX);
  EXPECT_TRUE(check_clock(end, end, Duration(0)));
  EXPECT_FALSE(check_clock(end, LogTime(), from_seconds(1e9)));
  EXPECT_FALSE(check_clock(LogTime(), end, from_seconds(1e9)));
  EXPECT_TRUE(check_clock(LogTime(), end, Duration::max()));
}

LaserScan scan_message() {
  LaserScan m;
  m.header = header_of(kNow, "laser");
  m.angle_min = -1.0F, m.angle_max = 1.0F, m.angle_increment = 0.5F;
  m.range_min = 0.1F, m.range_max = 30.0F;
  m.ranges = {1.0F, 2.0F, kNanF, kInfF, -1.0F};
  return m;
}

TEST(RosConvert, ScansOfAnyNumbers) {
  ASSERT_TRUE(laser_scan_of(scan_message(), kNow));
  using Field = float LaserScan::*;
  for (const Field field :
       {&LaserScan::angle_min, &LaserScan::angle_increment, &LaserScan::range_min,
        &LaserScan::range_max, &LaserScan::time_increment, &LaserScan::scan_time})
    for (const float value : {kNanF, kInfF, -kInfF, 1e30F, -1e30F, 1e-40F, 0.0F, 1e9F}) {
      LaserScan m = scan_message();
      m.*field = value;
      const auto scan = laser_scan_of(m, kNow);
      if (!scan) continue;
      EXPECT_EQ(scan->ranges_m.size(), 5U);
      for (std::size_t i = 0; i < 5; ++i) {
        EXPECT_TRUE(std::isfinite(scan->bearing(i).radians()));
        if (scan->returned(i)) {
          EXPECT_TRUE(std::isfinite(scan->ranges_m[i]) && scan->ranges_m[i] >= 0.0F);
        }
      }
      // The middle of a sweep of less than 10 s.
      EXPECT_LT(std::abs(to_seconds(scan->time - kNow)), 5.0);
      EXPECT_EQ(message_of(turned_over(*scan), "laser").ranges.size(), 5U);
    }
  LaserScan empty = scan_message();
  empty.ranges.clear();
  const auto none = laser_scan_of(empty, kNow);
  ASSERT_TRUE(none);
  EXPECT_TRUE(turned_over(*none).ranges_m.empty());
  EXPECT_TRUE(message_of(*none, "laser").ranges.empty());
  LaserScan many = scan_message();
  many.ranges.assign(1'000'000, 1.0F);
  expect_reason(laser_scan_of(many, kNow));
  LaserScan one = scan_message();
  one.ranges = {3.0F};
  one.angle_increment = 0.0F;
  EXPECT_TRUE(laser_scan_of(one, kNow));
}

PointCloud2 cloud_message() {
  return cloud_of({kNow, {{1.0F, 2.0F, 0.0F, -0.5F, 12.0F}, {kNanF, 0.0F, 0.0F, 0.0F, 0.0F}}},
                  "radar");
}

TEST(RosConvert, CloudsOfAnySizes) {
  const auto good = radar_scan_of(cloud_message(), kNow);
  ASSERT_TRUE(good);
  EXPECT_EQ(good->points.size(), 1U);
  using Field = std::uint32_t PointCloud2::*;
  for (const Field field : {&PointCloud2::width, &PointCloud2::height, &PointCloud2::point_step,
                            &PointCloud2::row_step})
    for (const std::uint32_t value : {0U, 1U, 2U, 3U, 19U, 21U, 1'000'000'000U, UINT32_MAX}) {
      PointCloud2 cloud = cloud_message();
      cloud.*field = value;
      const auto scan = radar_scan_of(cloud, kNow);
      if (scan) {
        EXPECT_LE(scan->points.size(), 2U);
      }
      cloud.data.clear();
      const auto bare = radar_scan_of(cloud, kNow);
      EXPECT_TRUE(!bare || bare->points.empty());
    }
  for (const std::uint32_t offset : {16U, 17U, 20U, UINT32_MAX - 2U, UINT32_MAX})
    for (int type = 0; type < 256; ++type) {
      PointCloud2 cloud = cloud_message();
      cloud.fields_of_point[0].offset = offset;
      cloud.fields_of_point[0].datatype = static_cast<std::uint8_t>(type);
      cloud.is_bigendian = type % 2 == 0;
      const auto scan = radar_scan_of(cloud, kNow);
      EXPECT_TRUE(!scan || scan->points.size() <= 2U);
    }
  // Empty rows, as many as there may be.
  PointCloud2 rows = cloud_message();
  rows.width = 0, rows.height = UINT32_MAX;
  const auto none = radar_scan_of(rows, kNow);
  ASSERT_TRUE(none);
  EXPECT_TRUE(none->points.empty());
  expect_reason(radar_scan_of(PointCloud2{}, kNow));
  RadarScan arrays = message_of(*good, "radar");
  arrays.width = UINT32_MAX;
  expect_reason(radar_scan_of(arrays, kNow));
  EXPECT_TRUE(radar_scan_of(RadarScan{}, kNow));
}

TEST(RosConvert, InertialSamplesOfAnyNumbers) {
  Imu m;
  m.header = header_of(kNow, "imu");
  ASSERT_TRUE(imu_of(m, kNow));
  for (const double bad : tests::kNotFinite) {
    for (double* field : {&m.angular_velocity.x, &m.linear_acceleration.z}) {
      *field = bad;
      expect_reason(imu_of(m, kNow));
      *field = 0.0;
    }
    m.orientation.w = bad;  // is not used
    EXPECT_TRUE(imu_of(m, kNow));
  }
  m.angular_velocity_covariance[0] = -1.0;
  expect_reason(turn_rate_of(m));
}

TEST(RosConvert, FixesOfAnyNumbers) {
  NavSatFix good = message_of(GnssFix{}, "gps");
  good.position_covariance = {1, 0, 0, 0, 1, 0, 0, 0, 4};
  ASSERT_TRUE(fix_of(good, kNow));
  for (double NavSatFix::*field :
       {&NavSatFix::latitude, &NavSatFix::longitude, &NavSatFix::altitude})
    for (const double bad : tests::kNotFinite) {
      NavSatFix m = good;
      m.*field = bad;
      expect_reason(fix_of(m, kNow));
    }
  for (const double bad : {tests::kNan, tests::kInf, -tests::kInf, 0.0, -1.0}) {
    NavSatFix m = good;
    m.position_covariance[4] = bad;
    expect_reason(fix_of(m, kNow));
  }
  // Correlations that no variances have are left out.
  for (const double correlated : {1.0, -1.0, 5.0, 1e300}) {
    NavSatFix m = good;
    m.position_covariance[1] = m.position_covariance[3] = correlated;
    const auto fix = fix_of(m, kNow);
    ASSERT_TRUE(fix);
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(fix->position_covariance_ned_m2);
    EXPECT_GT(eigen.eigenvalues().minCoeff(), 0.0) << correlated;
    EXPECT_EQ(fix->position_covariance_ned_m2.diagonal(), Eigen::Vector3d(1.0, 1.0, 4.0));
  }
}

TEST(RosConvert, PosesOfAnyNumbers) {
  std::vector<double> numbers(tests::kNotFinite.begin(), tests::kNotFinite.end());
  numbers.insert(numbers.end(), tests::kExtreme.begin(), tests::kExtreme.end());
  for (const double value : numbers) {
    for (double Quaternion::*field :
         {&Quaternion::x, &Quaternion::y, &Quaternion::z, &Quaternion::w}) {
      Quaternion q{0.0, 0.0, 0.0, 1.0};
      q.*field = value;
      const auto yaw = yaw_of(q);
      if (yaw) {
        EXPECT_TRUE(std::isfinite(yaw->angle().radians()));
      }
      const auto level = level_mounting_of({{0.0, 0.0, 0.0}, q});
      EXPECT_EQ(level.has_value(), yaw.has_value());
    }
    const auto pose = plane_pose_of({{value, 0.0, 0.0}, {0.0, 0.0, 0.0, 1.0}});
    EXPECT_EQ(pose.has_value(), std::isfinite(value));
    EXPECT_EQ(level_mounting_of({{0.0, value, 0.0}, {0.0, 0.0, 0.0, 1.0}}).has_value(),
              std::isfinite(value));
  }
  expect_reason(yaw_of({}));
  expect_reason(level_mounting_of({{}, {0.0, 0.0, 0.0, 1.0}}, tests::kNan));
}

TransformStamped link(const std::string& parent, const std::string& child) {
  return transform_of(SE2d(1.0, 0.0, Angle()), kNow, parent, child);
}

TEST(RosConvert, FramesInCirclesAndAlone) {
  FrameTree tree;
  expect_reason(tree.find("map", "laser"));
  EXPECT_TRUE(tree.find("", ""));
  tree.add(link("a", "a"));  // its own parent
  EXPECT_TRUE(tree.find("a", "a"));
  expect_reason(tree.find("a", "b"));
  tree.add(link("b", "a"));
  tree.add(link("c", "b"));
  tree.add(link("a", "c"));  // a circle
  for (const char* base : {"a", "b", "c"})
    for (const char* frame : {"a", "b", "c"}) EXPECT_TRUE(tree.find(base, frame)) << base << frame;
  expect_reason(tree.find("a", "d"));
  tree.add(link("x", "y"));  // not connected
  expect_reason(tree.find("a", "y"));
  TransformStamped bad = link("x", "z");
  bad.transform.rotation = {};
  tree.add(bad);
  expect_reason(tree.find("y", "z"));
  // A chain, as long as it may be.
  for (int i = 0; i < 1000; ++i)
    tree.add(link("/f" + std::to_string(i), "f" + std::to_string(i + 1)));
  const auto far = tree.find("f0", "/f1000");
  ASSERT_TRUE(far);
  EXPECT_NEAR(far->translation.x, 1000.0, 1e-6);
  tests::expect_value_semantics(tree, [](FrameTree& t) {
    t.add(link("f0", "new"));
    const auto found = t.find("f1000", "new");
    return found ? found->translation.x : tests::kNan;
  });
}

TEST(RosConvert, MapsOfAnyCells) {
  io::GridImage map{2, 2, 0.05, SE2d(), {kNanF, kInfF, -kInfF, 2.0F}};
  for (const std::int8_t cell : message_of(map, kNow, "map").data) EXPECT_EQ(cell, -1);
  EXPECT_TRUE(message_of(io::GridImage{}, kNow, "map").data.empty());
}

}  // namespace
}  // namespace wayfare::ros
