#include <wayfare/sync/scan_deskewer.hpp>

#include <cmath>
#include <cstddef>
#include <numbers>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace wayfare {
namespace {

using ::testing::HasSubstr;

const LogTime kAt = LogTime::from_seconds(3.0);
const Transform2<frame::Base, frame::Laser> kMounting(SE2d(0.2, -0.1, 0.5_rad));
const Eigen::Vector3d kVelocity(1.0, 0.0, std::numbers::pi / 2);  // 1 m/s and 90°/s

LogTime at(double s) { return kAt + from_seconds(s); }
SE2d base_at(LogTime time) { return SE2d::exp(to_seconds(time - kAt) * kVelocity); }

/// A sweep of 180 ms at `time`, as a laser sees points at rest in the frame of `base_at`.
LaserScan sweep_of(LogTime time, const std::vector<Eigen::Vector2d>& points) {
  LaserScan scan{time, Angle::degrees(-180), Angle::degrees(2), 0.05F, 50.0F, {}};
  scan.ranges_m.assign(180, 50.0F);
  scan.time_increment = from_seconds(0.001);
  scan.bearings.resize(180);
  for (std::size_t i = 0; i < 180; ++i) {
    const SE2d T = base_at(scan.beam_time(i)) * kMounting.raw();
    const Eigen::Vector2d p = T.inverse() * points[i % points.size()];
    scan.bearings[i] = Angle::radians(std::atan2(p.y(), p.x()));
    scan.ranges_m[i] = static_cast<float>(p.norm());
  }
  return scan;
}

const std::vector<Eigen::Vector2d> kPoints{{5.0, 1.0}, {-3.0, 4.0}, {2.0, -7.0}};

/// Every point is where it is, by the pose at the scan's time. Ranges have 24 bits.
void expect_undone(const LaserScan& instant, double tolerance_m) {
  for (std::size_t i = 0; i < instant.ranges_m.size(); ++i) {
    const Eigen::Vector2d p = base_at(instant.time) * kMounting.raw() *
                              Eigen::Vector2d(detail::beam_end(instant, i).head<2>());
    EXPECT_LT((p - kPoints[i % 3]).norm(), tolerance_m) << i;
  }
}

std::vector<OdometrySample> odometry(double from_s, double to_s) {
  std::vector<OdometrySample> samples;
  for (double t = from_s; t < to_s + 1e-9; t += 0.05)
    samples.push_back(
        {at(t), Transform2<frame::Odom, frame::Base>(SE2d(9, 8, 1_rad) * base_at(at(t)))});
  return samples;
}

std::vector<GyroSample> gyro(double from_s, double to_s) {
  std::vector<GyroSample> samples;
  for (double t = from_s; t < to_s + 1e-9; t += 0.01) samples.push_back({at(t), kVelocity[2]});
  return samples;
}

TEST(ScanDeskewer, AnInstantaneousScanIsItself) {
  LaserScan scan = sweep_of(kAt, kPoints);
  scan.time_increment = Duration::zero();
  ScanDeskewer deskewer(kMounting);
  EXPECT_EQ(*deskewer(scan, odometry(-1, 1)), &scan);
}

TEST(ScanDeskewer, UndoesASweepByOdometry) {
  ScanDeskewer deskewer(kMounting);
  const auto samples = odometry(-1, 1);
  const auto instant = deskewer(sweep_of(kAt, kPoints), samples);
  ASSERT_TRUE(instant);
  EXPECT_FALSE((*instant)->is_sweep());
  expect_undone(**instant, 1e-6);
}

// Odometry whose heading is worth nothing, beside a gyro.
TEST(ScanDeskewer, TurnsByTheGyroWhereThereIsOne) {
  auto samples = odometry(-1, 1);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const SE2d& T = samples[i].T_odom_base.raw();
    const Angle off = i % 2 == 0 ? 0.05_rad : -0.05_rad;
    samples[i].T_odom_base =
        Transform2<frame::Odom, frame::Base>(SE2d(T.translation(), T.rotation() * SO2d(off)));
  }
  ScanDeskewer deskewer(kMounting);
  // The arc between samples of such headings is off by 1.3 mm in the middle (0.05 m · 0.1 rad / 4);
  // the heading at the instant itself is off by up to 0.05 rad, along the 0.09 m to the ends.
  expect_undone(**deskewer(sweep_of(kAt, kPoints), samples, gyro(-0.1, 0.1)), 0.008);
}

TEST(ScanDeskewer, UndoesASweepByTheGyroAndTheVelocityBetweenPoses) {
  for (const bool by_gyro : {true, false}) {
    ScanDeskewer deskewer(kMounting);
    const SE2d T_map(4.0, 5.0, 2_rad);
    deskewer.placed(at(-0.4), T_map * base_at(at(-0.4)));
    deskewer.placed(at(-0.2), T_map * base_at(at(-0.2)));
    const auto turns = by_gyro ? gyro(-0.1, 0.1) : std::vector<GyroSample>();
    const auto instant = deskewer(sweep_of(kAt, kPoints), odometry(0.0, 1.0), turns);
    ASSERT_TRUE(instant);
    expect_undone(**instant, 1e-6);
  }
}

TEST(ScanDeskewer, ALeapOfTheMapIsNoVelocity) {
  ScanDeskewer deskewer(kMounting);
  deskewer.placed(at(-0.4), base_at(at(-0.4)));
  deskewer.placed(at(-0.2), base_at(at(-0.2)));
  deskewer.placed(at(-0.1), SE2d(3.0, 0.0, 0_rad) * base_at(at(-0.1)), true);
  const LaserScan sweep = sweep_of(kAt, kPoints);
  expect_undone(**deskewer(sweep, {}), 1e-6);
  // After a pause nothing is known.
  deskewer.placed(at(5.0), SE2d());
  EXPECT_EQ(*deskewer(sweep, {}), &sweep);
}

TEST(ScanDeskewer, WithoutMotionASweepIsLeftAsItIs) {
  ScanDeskewer deskewer(kMounting);
  const LaserScan sweep = sweep_of(kAt, kPoints);
  EXPECT_EQ(*deskewer(sweep, {}), &sweep);
  EXPECT_EQ(*deskewer(sweep, odometry(0.0, 1.0)), &sweep);  // begins in the middle of the sweep
  LaserScan endless = sweep;
  endless.time_increment = Duration::max();
  EXPECT_THAT(deskewer(endless, odometry(-1, 1)).error().message, HasSubstr("10 s or more"));
}

TEST(OdometryMotion, KnowsItsLimits) {
  auto samples = odometry(-1.0, 1.0);
  const OdometryMotion motion(samples, kMounting);
  EXPECT_TRUE(motion(at(-1.0)));
  EXPECT_TRUE(motion(at(0.97)));
  EXPECT_FALSE(motion(at(-1.001)));
  EXPECT_FALSE(motion(at(1.001)));
  samples.erase(samples.begin() + 10, samples.begin() + 25);  // 0.8 s
  EXPECT_FALSE(OdometryMotion(samples, kMounting)(at(-0.2)));
  EXPECT_FALSE(OdometryMotion({}, kMounting)(kAt));
  LaserScan instant;
  const auto done =
      deskew(sweep_of(at(0.95), kPoints), OdometryMotion(samples, kMounting), at(0.95), instant);
  EXPECT_THAT(done.error().message, HasSubstr("the motion does not cover the sweep"));
}

TEST(VelocityMotion, IsSilentWhereTheGyroIs) {
  const auto turns = gyro(-0.1, 0.05);
  const VelocityMotion motion(kAt, kVelocity, kMounting, turns);
  EXPECT_TRUE(motion(at(-0.09)));
  EXPECT_TRUE(motion(at(0.04)));
  EXPECT_FALSE(motion(at(0.07)));
}

}  // namespace
}  // namespace wayfare
