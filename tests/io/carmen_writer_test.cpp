#include <wayfare/io/carmen.hpp>

#include <cmath>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <wayfare/core/random.hpp>

namespace wayfare::io {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

// A run with difficult numbers: thirds of a second, long decimals, a few beams without return.
Recording recording(std::size_t beams, double step_deg, const SE2d& T_base_laser) {
  Rng rng(3);
  Recording run;
  run.T_base_laser = Transform2<frame::Base, frame::Laser>(T_base_laser);
  for (int i = 0; i < 12; ++i) {
    const LogTime time = LogTime::from_nanoseconds(976'052'857'137'530'001 + i * 333'333'333LL);
    const SE2d pose(rng.normal(), rng.normal(), Angle::radians(rng.uniform(-3.1, 3.1)));
    run.odometry.push_back({time, Transform2<frame::Odom, frame::Base>(pose)});
    LaserScan scan{time + Duration(100'000'000),
                   Angle::degrees(-90),
                   Angle::degrees(step_deg),
                   0.05F,
                   20.0F,
                   {}};
    for (std::size_t b = 0; b < beams; ++b)
      scan.ranges_m.push_back(b % 50 == 7 ? 20.0F : static_cast<float>(rng.uniform(0.1, 19.0)));
    run.scans.push_back(scan);
  }
  return run;
}

void expect_same(const Recording& written, const Recording& read) {
  ASSERT_EQ(read.scans.size(), written.scans.size());
  for (std::size_t i = 0; i < read.scans.size(); ++i) {
    const LaserScan &a = written.scans[i], &b = read.scans[i];
    EXPECT_EQ(b.time, a.time);
    EXPECT_EQ(b.ranges_m, a.ranges_m);
    EXPECT_EQ(b.max_range_m, a.max_range_m);
    EXPECT_EQ(b.time_increment, a.time_increment);
    EXPECT_NEAR(b.first_bearing.radians(), a.first_bearing.radians(), 1e-15);
    EXPECT_NEAR(b.bearing_step.radians(), a.bearing_step.radians(), 1e-15);
  }
  ASSERT_EQ(read.odometry.size(), written.odometry.size());
  for (std::size_t i = 0; i < read.odometry.size(); ++i) {
    const SE2d &a = written.odometry[i].T_odom_base.raw(), &b = read.odometry[i].T_odom_base.raw();
    EXPECT_EQ(read.odometry[i].time, written.odometry[i].time);
    EXPECT_EQ(b.translation(), a.translation());
    EXPECT_NEAR((a.inverse() * b).heading().radians(), 0.0, 1e-15);
  }
  EXPECT_LT(read.T_base_laser.raw().minus(written.T_base_laser.raw()).norm(), 1e-12);
}

void expect_read_back(const std::string& text, const Recording& run) {
  const auto log = parse_carmen(text, "log");
  ASSERT_TRUE(log.has_value()) << log.error().to_string();
  EXPECT_TRUE(log->problems.empty());
  expect_same(run, log->recording);
}

TEST(CarmenWriter, FrontLaserReadsBackTheSame) {
  const Recording run = recording(180, 1.0, SE2d(0.21, 0.0, Angle{}));
  const std::string text = format_carmen(run);
  EXPECT_THAT(text, HasSubstr("\nFLASER 180 "));
  EXPECT_THAT(text, HasSubstr(" 976052857.137530001 "));
  expect_read_back(text, run);
}

TEST(CarmenWriter, SweepsReadBackTheSame) {
  for (const std::int64_t ns : {505'051, -505'051}) {
    Recording run = recording(180, 1.0, SE2d(0.21, 0.0, Angle{}));
    for (LaserScan& scan : run.scans) scan.time_increment = Duration(ns);
    expect_read_back(format_carmen(run), run);
  }
}

TEST(CarmenWriter, OtherLasersReadBackTheSame) {
  const Recording run = recording(250, 0.7, SE2d(0.1, -0.2, Angle::degrees(4)));
  const std::string text = format_carmen(run);
  EXPECT_THAT(text, Not(HasSubstr("\nFLASER")));
  EXPECT_THAT(text, HasSubstr("\nROBOTLASER1 "));
  expect_read_back(text, run);
}

TEST(CarmenWriter, LaserPosesInterpolateTheOdometry) {
  Recording run = recording(180, 1.0, SE2d(0.21, 0.0, Angle{}));
  const auto log = parse_carmen(format_carmen(run), "log");
  ASSERT_TRUE(log.has_value());
  ASSERT_EQ(log->reported_poses.size(), run.scans.size());
  // A scan is 0.1 s after its odometry sample, at 0.3 of the interval to the next.
  const SE2d between = interpolate(run.odometry[4].T_odom_base.raw(),
                                   run.odometry[5].T_odom_base.raw(), 0.1 / 0.333333333);
  const SE2d laser = between * run.T_base_laser.raw();
  EXPECT_LT(log->reported_poses[4].T_map_base.raw().minus(laser).norm(), 1e-12);
}

TEST(CarmenWriter, NonFiniteRangesBecomeNoReturns) {
  Recording run = recording(180, 1.0, SE2d());
  run.scans[0].ranges_m[0] = std::numeric_limits<float>::quiet_NaN();
  run.scans[0].ranges_m[1] = std::numeric_limits<float>::infinity();
  run.scans[0].ranges_m[2] = -1.0F;
  const auto log = parse_carmen(format_carmen(run), "log");
  ASSERT_TRUE(log.has_value());
  EXPECT_TRUE(log->problems.empty());
  for (std::size_t beam = 0; beam < 3; ++beam)
    EXPECT_FALSE(log->recording.scans[0].returned(beam)) << beam;
}

TEST(CarmenWriter, ARecordingWithoutOdometryIsStillALog) {
  Recording run = recording(180, 1.0, SE2d());
  run.odometry.clear();
  const auto log = parse_carmen(format_carmen(run), "log");
  ASSERT_TRUE(log.has_value());
  EXPECT_EQ(log->recording.scans.size(), run.scans.size());
}

}  // namespace
}  // namespace wayfare::io
