// Input that is bad, late, missing or wrong.

#include <cmath>
#include <functional>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <wayfare/eval/trajectory_error.hpp>
#include <wayfare/slam/submap_slam.hpp>

#include "support.hpp"

namespace wayfare {
namespace {

using ::testing::HasSubstr;

constexpr float kNoNumber = std::numeric_limits<float>::quiet_NaN();

/// Two rounds of the loop with a modified recording; returns the final error.
double rmse_after(const std::function<void(Recording&)>& harm) {
  auto run = simulate(kRing, slipping_robot(), 1);
  harm(run.recording);
  SubmapSlamOptions options;
  options.submap_nodes = 20;
  const auto slam = run_submap_slam(run.recording, options);
  if (!slam) return std::numeric_limits<double>::infinity();
  return eval::absolute_error(slam->trajectory, run.truth).translation_m.rmse;
}

TEST(SubmapSlamFaults, RefusesABadScanAndContinues) {
  SubmapSlam slam;
  ASSERT_TRUE(slam.add_scan(room_scan(1.0, 3.0, 2.0)));
  LaserScan empty = room_scan(2.0, 3.0, 2.0);
  empty.ranges_m.clear();
  const auto no_beams = slam.add_scan(empty);
  ASSERT_FALSE(no_beams);
  EXPECT_THAT(no_beams.error().message, HasSubstr("no beams"));
  EXPECT_FALSE(slam.add_scan(room_scan(0.5, 3.0, 2.0)));
  const SE2d nowhere(std::numeric_limits<double>::infinity(), 0.0, Angle{});
  EXPECT_FALSE(
      slam.add_scan(room_scan(2.0, 3.0, 2.0), {Transform2<frame::Odom, frame::Base>(nowhere), {}}));
  EXPECT_FALSE(slam.add_scan(room_scan(2.0, 3.0, 2.0),
                             {{}, Angle::radians(std::numeric_limits<double>::quiet_NaN())}));
  EXPECT_EQ(slam.statistics().scans, 1U);
  const auto next = slam.add_scan(room_scan(2.0, 3.05, 2.0));
  ASSERT_TRUE(next);
  EXPECT_NEAR(next->T_map_base.raw().x(), 0.05, 0.02);
  const auto none = run_submap_slam({});
  ASSERT_FALSE(none);
  EXPECT_THAT(none.error().message, HasSubstr("no scans"));
}

TEST(SubmapSlamFaults, StartsWithoutReturns) {
  SubmapSlam slam;
  LaserScan dark = room_scan(0.0, 3.0, 2.0);
  for (float& r : dark.ranges_m) r = kNoNumber;
  ASSERT_TRUE(slam.add_scan(dark));
  for (int i = 1; i < 30; ++i)
    ASSERT_TRUE(slam.add_scan(room_scan(0.1 * i, 3.0 + 0.01 * i, 2.0))) << i;
  EXPECT_NEAR(
      slam.trajectory()[29].T_map_base.raw().x() - slam.trajectory()[20].T_map_base.raw().x(), 0.09,
      0.02);
}

TEST(SubmapSlamFaults, LidarCoveredForFiveSeconds) {
  EXPECT_LT(rmse_after([](Recording& r) {
              const LogTime from = r.scans[r.scans.size() / 3].time;
              for (LaserScan& s : r.scans)
                if (s.time >= from && s.time < from + from_seconds(5))
                  for (float& range : s.ranges_m) range = 0.0F;
            }),
            0.15);
}

TEST(SubmapSlamFaults, IrregularDuplicatedAndMissingScans) {
  EXPECT_LT(rmse_after([](Recording& r) {
              std::vector<LaserScan> kept;
              for (std::size_t i = 0; i < r.scans.size(); ++i) {
                if (i % 5 == 1 || i % 7 == 3) continue;
                kept.push_back(r.scans[i]);
                if (i % 11 == 0) kept.push_back(r.scans[i]);
                if (i % 3 == 0)
                  for (std::size_t b = i % 13; b < kept.back().ranges_m.size(); b += 4)
                    kept.back().ranges_m[b] = kNoNumber;
              }
              r.scans = std::move(kept);
            }),
            0.15);
}

// Counters that are reset: a jump of 7 m and 90° from one scan to the next.
TEST(SubmapSlamFaults, OdometryReset) {
  EXPECT_LT(rmse_after([](Recording& r) {
              const LogTime from = r.scans[r.scans.size() / 2].time;
              const SE2d leap(5.0, -5.0, Angle::degrees(90));
              for (OdometrySample& o : r.odometry)
                if (o.time >= from)
                  o.T_odom_base = Transform2<frame::Odom, frame::Base>(leap * o.T_odom_base.raw());
            }),
            0.15);
}

// Scans 0.2 s apart, every seventh stamped a millisecond after the previous one: a motion in 0.2 s
// must not become a velocity over 1 ms.
TEST(SubmapSlamFaults, TimestampJitterWithoutOdometry) {
  auto run = simulate(kRing, slipping_robot(), 1);
  run.recording.odometry.clear();
  std::vector<LogTime> when;
  for (std::size_t i = 0; i < run.recording.scans.size(); ++i) {
    LaserScan& s = run.recording.scans[i];
    when.push_back(s.time);
    if (i % 7 == 6) s.time = run.recording.scans[i - 1].time + from_seconds(0.001);
  }
  SubmapSlamOptions options;
  options.submap_nodes = 20;
  auto slam = run_submap_slam(run.recording, options);
  ASSERT_TRUE(slam && slam->trajectory.size() == when.size());
  for (std::size_t i = 0; i < when.size(); ++i) slam->trajectory[i].time = when[i];
  EXPECT_LT(eval::absolute_error(slam->trajectory, run.truth).translation_m.rmse, 0.15);
}

/// The loop without odometry, with a gyroscope that stops after a third.
TEST(SubmapSlamFaults, GyroscopeStops) {
  EXPECT_LT(rmse_after([](Recording& r) {
              const auto& o = r.odometry;
              for (std::size_t i = 1; i < o.size() / 3; ++i) {
                const SE2d step = o[i - 1].T_odom_base.raw().inverse() * o[i].T_odom_base.raw();
                const double dt = to_seconds(o[i].time - o[i - 1].time);
                r.gyro.push_back({o[i].time, step.heading().radians() / dt});
              }
              r.odometry.clear();
            }),
            0.15);
}

// A saved map with any byte changed or truncated anywhere: an Error with its position.
TEST(SubmapSlamFaults, DamagedSavedMapsAreRefused) {
  SubmapSlam slam;
  for (int i = 0; i < 12; ++i) ASSERT_TRUE(slam.add_scan(room_scan(0.1 * i, 3.0 + 0.05 * i, 2.0)));
  const auto good = slam.save();
  ASSERT_TRUE(SubmapSlam::restore(good));
  for (std::size_t i = 0; i < good.size(); i += 7) {
    auto bad = good;
    bad[i] ^= static_cast<std::uint8_t>(1U << (i % 8));
    const auto restored = SubmapSlam::restore(bad);
    ASSERT_FALSE(restored) << "byte " << i;
    EXPECT_EQ(restored.error().code, ErrorCode::parse);
    EXPECT_FALSE(SubmapSlam::restore(std::span(good).first(i)));
  }
}

}  // namespace
}  // namespace wayfare
