// ROS messages and measurements: round trips, and errors with their reasons.

#include <wayfare/ros/convert.hpp>

#include <cmath>
#include <limits>
#include <numbers>

#include <gmock/gmock.h>

#include <wayfare/core/random.hpp>

namespace wayfare::ros {
namespace {

using ::testing::HasSubstr;
constexpr double kPi = std::numbers::pi;
constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
const LogTime kTime = LogTime::from_nanoseconds(1'632'233'878'936'484'001);

template <class T>
std::string why(const Result<T>& result) {
  return result ? "no error" : result.error().to_string();
}

TEST(Convert, StampsAreExactAndZeroIsNotSet) {
  EXPECT_EQ(stamp_of(kTime), (Stamp{1'632'233'878, 936'484'001}));
  EXPECT_EQ(*time_of(stamp_of(kTime)), kTime);
  EXPECT_THAT(why(time_of({0, 0})), HasSubstr("is zero: the sender set no time"));
  EXPECT_THAT(why(time_of({-1, 5})), HasSubstr("before 1970"));
  EXPECT_THAT(why(time_of({1, 1'000'000'000})), HasSubstr("second or more of nanoseconds"));
  EXPECT_TRUE(time_of({0, 1}));
}

TEST(Convert, ReportsOtherFramesAndClocks) {
  Header header{0, {1, 0}, "/laser"};
  EXPECT_TRUE(check_frame(header, "laser"));
  EXPECT_THAT(why(check_frame(header, "base_link")),
              HasSubstr("is of frame 'laser', not of 'base"));
  header.frame_id.clear();
  EXPECT_THAT(why(check_frame(header, "laser")), HasSubstr("names no frame"));
  EXPECT_TRUE(check_clock(kTime, kTime + from_seconds(1.0), from_seconds(1.0)));
  EXPECT_THAT(why(check_clock(kTime, kTime + from_seconds(2.0), from_seconds(1.0))),
              HasSubstr("2.000000 s behind the receiver's clock"));
  EXPECT_THAT(why(check_clock(kTime + from_seconds(9.0), kTime, from_seconds(1.0))),
              HasSubstr("9.000000 s ahead of"));
}

TEST(Convert, RotationsSurviveTheQuaternionBitForBit) {
  Rng rng(3);
  int lost = 0;
  constexpr int kTimes = 100'000;
  for (int i = 0; i < kTimes; ++i) {
    const SO2d r(Angle::radians(2.0 * kPi * (rng.uniform() - 0.5)));
    const SO2d back = *yaw_of(quaternion_of(r));
    lost += back.cos() != r.cos() || back.sin() != r.sin();
    EXPECT_NEAR(back.minus(r)[0], 0.0, 1e-15);
  }
  EXPECT_EQ(lost, 0);
  for (const double turn : {0.0, 0.25, 0.5, -0.25, 1e-9}) {
    const SO2d r(Angle::radians(2.0 * kPi * turn));
    EXPECT_EQ(yaw_of(quaternion_of(r))->sin(), r.sin()) << turn;
    EXPECT_EQ(yaw_of(quaternion_of(r))->cos(), r.cos()) << turn;
  }
  EXPECT_THAT(why(yaw_of({0, 0, 0, 0})), HasSubstr("no unit quaternion"));
  EXPECT_FALSE(yaw_of({NAN, 0, 0, 1}));
}

TEST(Convert, YawOfATiltedPose) {
  // Roll by 20 degrees after a yaw of 0.7 rad does not change the yaw.
  const Eigen::Quaterniond q(Eigen::AngleAxisd(0.7, Eigen::Vector3d::UnitZ()) *
                             Eigen::AngleAxisd(0.35, Eigen::Vector3d::UnitX()));
  EXPECT_NEAR(yaw_of({q.x(), q.y(), q.z(), q.w()})->angle().radians(), 0.7, 1e-12);
}

TEST(Convert, LaserScansRoundTrip) {
  const wayfare::LaserScan scan{kTime,  Angle::degrees(-90.0),      Angle::degrees(1.0), 0.05F,
                                81.83F, {1.0F, kNaN, 80.0F, 81.83F}};
  const LaserScan message = message_of(scan, "laser");
  EXPECT_LT(message.range_max, scan.max_range_m);  // ROS counts the limit itself as measured
  const auto back = laser_scan_of(message, *time_of(message.header.stamp));
  ASSERT_TRUE(back) << why(back);
  EXPECT_EQ(back->time, scan.time);
  EXPECT_EQ(back->first_bearing.radians(), scan.first_bearing.radians());
  EXPECT_EQ(back->bearing_step.radians(), scan.bearing_step.radians());
  EXPECT_EQ(back->min_range_m, scan.min_range_m);
  EXPECT_EQ(back->max_range_m, scan.max_range_m);
  for (std::size_t i = 0; i < 4; ++i) EXPECT_EQ(back->returned(i), scan.returned(i)) << i;
}

TEST(Convert, BearingsSurviveSinglePrecision) {
  for (const double degrees : {0.25, 0.5, 1.0, 0.36, 0.3515625, 0.33333, 135.0, 119.885, 180.0}) {
    const wayfare::LaserScan scan{
        kTime, Angle::degrees(-degrees), Angle::degrees(degrees), 0.1F, 9.0F, {1.0F}};
    const auto back = laser_scan_of(message_of(scan, "l"), kTime);
    EXPECT_EQ(back->first_bearing.radians(), scan.first_bearing.radians()) << degrees;
    EXPECT_EQ(back->bearing_step.radians(), scan.bearing_step.radians()) << degrees;
  }
}

LaserScan clockwise() {
  LaserScan m;
  m.angle_min = 0.5F, m.angle_max = -0.5F, m.angle_increment = -0.5F;
  m.range_min = 0.1F, m.range_max = 10.0F;
  m.ranges = {1.0F, 2.0F, 3.0F};
  return m;
}

TEST(Convert, AClockwiseScanIsReversed) {
  const auto scan = laser_scan_of(clockwise(), kTime);
  ASSERT_TRUE(scan);
  EXPECT_GT(scan->bearing_step.radians(), 0.0);
  EXPECT_THAT(scan->ranges_m, ::testing::ElementsAre(3.0F, 2.0F, 1.0F));
  EXPECT_NEAR(scan->bearing(0).radians(), -0.5, 1e-7);
  EXPECT_NEAR(scan->bearing(2).radians(), 0.5, 1e-7);
}

TEST(Convert, TheTimeOfASweepIsItsMiddle) {
  LaserScan m = clockwise();
  m.time_increment = 0.1F;  // three beams: the middle one is 0.1 s after the stamp
  EXPECT_NEAR(to_seconds(laser_scan_of(m, kTime)->time - kTime), 0.1, 1e-8);
}

TEST(Convert, TheTimesOfBeamsRoundTrip) {
  wayfare::LaserScan scan{kTime, Angle::degrees(-90.0), Angle::degrees(1.0), 0.05F, 80.0F, {}};
  for (int i = 0; i < 181; ++i) scan.ranges_m.push_back(1.0F + 0.1F * static_cast<float>(i));
  for (const std::int64_t ns : {505'051, -505'051}) {  // the laser turns either way
    scan.time_increment = Duration(ns);
    const LaserScan message = message_of(scan, "laser");
    EXPECT_GT(message.time_increment, 0.0F);
    EXPECT_EQ(message.angle_increment > 0.0F, ns > 0);
    const LogTime stamp = *time_of(message.header.stamp);
    EXPECT_NEAR(to_seconds(scan.time - stamp), 0.5 * scan.sweep_s(), 1e-9);
    const auto back = laser_scan_of(message, stamp);
    ASSERT_TRUE(back) << why(back);
    EXPECT_NEAR(to_seconds(back->time - scan.time), 0.0, 2e-9);
    EXPECT_EQ(back->time_increment, scan.time_increment);
    EXPECT_EQ(back->ranges_m, scan.ranges_m);
    EXPECT_EQ(back->first_bearing.radians(), scan.first_bearing.radians());
  }
  const wayfare::LaserScan turned = turned_over(scan);
  EXPECT_EQ(turned.time_increment, -scan.time_increment);
}

TEST(Convert, InvalidScansAreRefused) {
  LaserScan m = clockwise();
  m.range_max = 0.0F;
  EXPECT_THAT(why(laser_scan_of(m, kTime)), HasSubstr("range_min, range_max: do not enclose"));
  m = clockwise(), m.angle_increment = kNaN;
  EXPECT_THAT(why(laser_scan_of(m, kTime)), HasSubstr("not finite"));
  m = clockwise(), m.angle_increment = 4.0F;
  EXPECT_THAT(why(laser_scan_of(m, kTime)), HasSubstr("no scan of at most a turn"));
  m.angle_increment = 0.0F;
  EXPECT_FALSE(laser_scan_of(m, kTime));
}

TEST(Convert, ALaserUpsideDownMeasuresTheSamePoints) {
  // Roll by 180°, then yaw by 0.4 rad: bearing b of the laser points to 0.4 - b.
  const Eigen::Quaterniond q(Eigen::AngleAxisd(0.4, Eigen::Vector3d::UnitZ()) *
                             Eigen::AngleAxisd(kPi, Eigen::Vector3d::UnitX()));
  const auto mounting = level_mounting_of({{0.2, -0.1, 0.5}, {q.x(), q.y(), q.z(), q.w()}});
  ASSERT_TRUE(mounting);
  EXPECT_TRUE(mounting->upside_down);
  const wayfare::LaserScan scan{kTime, Angle::radians(-0.3), Angle::radians(0.1), 0.1F,
                                10.0F, {2.0F, 4.0F}};
  const wayfare::LaserScan turned = turned_over(scan);
  for (std::size_t i = 0; i < 2; ++i) {
    const double b = scan.bearing(i).radians();
    const auto r = static_cast<double>(scan.ranges_m[i]);
    const Eigen::Vector3d wanted = q * Eigen::Vector3d(r * std::cos(b), r * std::sin(b), 0.0) +
                                   Eigen::Vector3d(0.2, -0.1, 0.5);
    const std::size_t j = 1 - i;
    const double t = turned.bearing(j).radians();
    const Eigen::Vector2d got =
        mounting->T_base_sensor.raw() * Eigen::Vector2d(double(turned.ranges_m[j]) * std::cos(t),
                                                        double(turned.ranges_m[j]) * std::sin(t));
    EXPECT_NEAR((got - wanted.head<2>()).norm(), 0.0, 1e-6);
  }
  EXPECT_FALSE(level_mounting_of({{}, {0, 0, 0, 1}})->upside_down);
  EXPECT_THAT(why(level_mounting_of({{}, {std::sin(0.25), 0, 0, std::cos(0.25)}})),
              HasSubstr("tilts the sensor by 28.6"));
}

wayfare::RadarScan radar_scan() {
  return {kTime, {{1.0F, -2.0F, 0.5F, -0.25F, 12.0F}, {3.0F, 4.0F, 0.0F, 1.5F, 7.0F}}};
}

TEST(Convert, RadarScansRoundTripInBothMessages) {
  EXPECT_EQ(radar_scan_of(message_of(radar_scan(), "radar"), kTime)->points, radar_scan().points);
  EXPECT_EQ(radar_scan_of(cloud_of(radar_scan(), "radar"), kTime)->points, radar_scan().points);
  RadarScan uneven = message_of(radar_scan(), "radar");
  uneven.velocities.pop_back();
  EXPECT_THAT(why(radar_scan_of(uneven, kTime)), HasSubstr("array of 1 for a width of 2"));
}

TEST(Convert, CloudsOfOtherLayouts) {
  // Two rows of one point each, big endian, a gap in the row, with a double and a byte field.
  PointCloud2 cloud;
  cloud.height = 2, cloud.width = 1, cloud.point_step = 17, cloud.row_step = 20;
  cloud.is_bigendian = true;
  cloud.fields_of_point = {{"x", 0, 8, 1}, {"y", 8, 7, 1}, {"z", 12, 2, 1}, {"snr", 13, 6, 1}};
  cloud.data.assign(37, 0);
  cloud.data[0] = 0x3f, cloud.data[1] = 0xf0;  // 1.0
  cloud.data[8] = 0xc0;                        // -2.0
  cloud.data[12] = 200, cloud.data[16] = 30;
  cloud.data[20] = 0x7f, cloud.data[21] = 0xf8;  // NaN: dropped
  const auto scan = radar_scan_of(cloud, kTime);
  ASSERT_TRUE(scan) << why(scan);
  ASSERT_EQ(scan->points.size(), 1U);
  EXPECT_EQ(scan->points[0], (RadarPoint{1.0F, -2.0F, 200.0F, 0.0F, 30.0F}));
  cloud.data.pop_back();
  EXPECT_THAT(why(radar_scan_of(cloud, kTime)), HasSubstr("has 36 bytes for 1 x 2 points of 17"));
  cloud.height = cloud.width = 4'000'000'000U;
  EXPECT_FALSE(radar_scan_of(cloud, kTime));
  cloud.fields_of_point[0].offset = 10;  // beyond the end of the point
  EXPECT_THAT(why(radar_scan_of(cloud, kTime)), HasSubstr("no x, y and z"));
}

TEST(Convert, InertialUnits) {
  const ImuSample sample{kTime, {0.1, 0.2, 0.3}, {1.0, 2.0, 9.8}};
  Imu message = message_of(sample, "imu");
  EXPECT_EQ(imu_of(message, kTime)->angular_rate_radps, sample.angular_rate_radps);
  EXPECT_EQ(imu_of(message, kTime)->specific_force_mps2, sample.specific_force_mps2);
  EXPECT_EQ(message.orientation_covariance[0], -1.0);
  message.angular_velocity.y = NAN;
  EXPECT_THAT(why(imu_of(message, kTime)), HasSubstr("not finite"));
  message = message_of(sample, "imu");
  message.linear_acceleration_covariance[0] = -1.0;
  EXPECT_THAT(why(imu_of(message, kTime)), HasSubstr("not measured"));
  const Eigen::Vector3d field(20.0, -1.0, 43.0);
  EXPECT_LT((field_uT_of(magnetic_message_of(field, kTime, "imu")) - field).norm(), 1e-12);
}

TEST(Convert, FixesAreConvertedFromEastNorthUp) {
  NavSatFix m;
  m.latitude = 48.5, m.longitude = -9.25, m.altitude = 300.0;
  m.position_covariance = {1.0, 0.1, 0.2, 0.1, 4.0, 0.3, 0.2, 0.3, 9.0};
  m.position_covariance_type = 3;
  const auto fix = fix_of(m, kTime);
  ASSERT_TRUE(fix) << why(fix);
  // North first, east second, and down is minus up.
  const Eigen::Matrix3d ned{{4.0, 0.1, -0.3}, {0.1, 1.0, -0.2}, {-0.3, -0.2, 9.0}};
  EXPECT_EQ(fix->position_covariance_ned_m2, ned);
  EXPECT_EQ(message_of(*fix, "gnss").position_covariance, m.position_covariance);
  m.status.status = -1;
  EXPECT_THAT(why(fix_of(m, kTime)), HasSubstr("no fix"));
  m.status.status = 0, m.latitude = 91.0;
  EXPECT_THAT(why(fix_of(m, kTime)), HasSubstr("no position on the Earth"));
}

TEST(Convert, OdometryAndTransforms) {
  const SE2d pose(1.25, -3.5, Angle::radians(2.9));
  const OdometrySample sample{kTime, Transform2<frame::Odom, frame::Base>(pose)};
  const Odometry message = message_of(sample, "odom", "base_link");
  EXPECT_EQ(frame_of(message.header), "odom");
  const auto back = odometry_of(message, kTime);
  ASSERT_TRUE(back);
  EXPECT_EQ(back->T_odom_base.raw().translation(), pose.translation());
  EXPECT_EQ(back->T_odom_base.raw().rotation().sin(), pose.rotation().sin());
  EXPECT_THAT(why(odometry_of(Odometry{}, kTime)), HasSubstr("orientation"));
  const auto tf = transform_of(pose, kTime, "map", "odom");
  EXPECT_EQ(tf.child_frame_id, "odom");
  EXPECT_EQ(tf.transform.translation.y, -3.5);
}

TEST(Convert, MapsInPercent) {
  const io::GridImage map{3, 1, 0.05, SE2d(-1.0, -2.0, Angle()), {0.0F, kNaN, 0.985F}};
  const OccupancyGrid message = message_of(map, kTime, "map");
  EXPECT_THAT(message.data, ::testing::ElementsAre(0, -1, 99));
  EXPECT_EQ(message.info.width, 3U);
  EXPECT_EQ(message.info.resolution, 0.05F);
  EXPECT_EQ(message.info.origin.position.y, -2.0);
}

}  // namespace
}  // namespace wayfare::ros
