#include <wayfare/sensors/deskew.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <wayfare/sensors/pose_history.hpp>
#include <wayfare/sensors/recording.hpp>

namespace wayfare {
namespace {

using ::testing::HasSubstr;

constexpr double kPi = std::numbers::pi;
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kSweep_s = 0.18;
constexpr std::size_t kBeams = 361;  // 0.5 ms from one to the next

const LogTime kAt = LogTime::from_seconds(20.0);

double since(LogTime time) { return to_seconds(time - kAt); }

/// The distance to the walls x = ±3 m, y = ±2 m from `p` along `d`: closed form.
double to_wall(const Eigen::Vector2d& p, const Eigen::Vector2d& d) {
  const double x = ((d.x() > 0 ? 3.0 : -3.0) - p.x()) / d.x();
  const double y = ((d.y() > 0 ? 2.0 : -2.0) - p.y()) / d.y();
  return std::min(std::abs(x), std::abs(y));
}

LaserScan empty_sweep(Duration increment = from_seconds(kSweep_s) / (kBeams - 1)) {
  LaserScan scan{kAt, Angle::degrees(-179.7), Angle::degrees(359.0 / (kBeams - 1)), 0.05F, 20.0F,
                 {}};
  scan.ranges_m.resize(kBeams);
  scan.time_increment = increment;
  return scan;
}

/// A sweep in the room from a laser that moves along `motion`.
template <class Motion>
LaserScan sweep_in_room(const Motion& motion, LaserScan scan = empty_sweep()) {
  for (std::size_t i = 0; i < kBeams; ++i) {
    const SE2d pose = motion(scan.beam_time(i));
    const SO2d beam(pose.heading() + scan.bearing(i));
    scan.ranges_m[i] =
        static_cast<float>(to_wall(pose.translation(), beam * Eigen::Vector2d::UnitX()));
  }
  return scan;
}

/// 1 m/s and 90°/s on a circle.
SE2d turning(LogTime time) {
  return SE2d(0.4, -0.3, 0.3_rad).plus(since(time) * Eigen::Vector3d(1.0, 0.1, kPi / 2));
}

TEST(LaserScan, BeamsOfASweepHaveTimesAroundItsMiddle) {
  const LaserScan scan = empty_sweep();
  EXPECT_TRUE(scan.is_sweep());
  EXPECT_NEAR(scan.sweep_s(), kSweep_s, 1e-9);
  EXPECT_EQ(scan.beam_time(180), kAt);
  EXPECT_NEAR(since(scan.beam_time(0)), -0.09, 1e-9);
  EXPECT_NEAR(since(scan.end_time()), 0.09, 1e-9);
  const LaserScan clockwise = empty_sweep(-scan.time_increment);
  EXPECT_NEAR(since(clockwise.beam_time(0)), 0.09, 1e-9);
  EXPECT_NEAR(since(clockwise.end_time()), 0.09, 1e-9);
  LaserScan instant = empty_sweep(Duration::zero());
  EXPECT_FALSE(instant.is_sweep());
  EXPECT_EQ(instant.beam_time(0), kAt);
  EXPECT_EQ(instant.end_time(), kAt);
}

TEST(LaserScan, ThinnedBeamsKeepTheirTimes) {
  const LaserScan whole = empty_sweep();
  for (const double field : {0.0, 120.0})
    for (const std::size_t every : {1U, 7U}) {
      LaserScan thinned = whole;
      thin(thinned, {.beams = every, .field_of_view_deg = field});
      for (std::size_t i = 0; i < thinned.ranges_m.size(); ++i) {
        const double at = (thinned.bearing(i) - whole.first_bearing) / whole.bearing_step;
        const auto beam = static_cast<std::size_t>(std::lround(at));
        EXPECT_NEAR(since(thinned.beam_time(i)), since(whole.beam_time(beam)), 1e-6) << i;
      }
    }
}

// Ranges are rounded to 24 bits: 20 m · 2⁻²⁴ = 1.2e-6 m along the beam, measured and moved. The
// motion moves a point by no more. A bearing is exact to 4e-16 rad.
constexpr double kRounding_m = 3e-6;

template <class Motion>
void expect_instantaneous(const LaserScan& sweep, const Motion& motion) {
  LaserScan instant;
  ASSERT_TRUE(deskew(sweep, motion, sweep.time, instant));
  EXPECT_EQ(instant.time, sweep.time);
  EXPECT_FALSE(instant.is_sweep());
  ASSERT_EQ(instant.ranges_m.size(), kBeams);
  const SE2d then = motion(sweep.time);
  for (std::size_t i = 0; i < kBeams; ++i) {
    // As the walls are seen along the same bearing from the pose then.
    const SO2d beam(then.heading() + instant.bearing(i));
    const double expected = to_wall(then.translation(), beam * Eigen::Vector2d::UnitX());
    // A wall seen at a shallow angle turns an error along the old beam into one along the new.
    EXPECT_NEAR(static_cast<double>(instant.ranges_m[i]), expected, 5.0 * kRounding_m) << i;
  }
}

TEST(Deskew, ASweepOfAMovingLaserIsTheInstantaneousScan) {
  expect_instantaneous(sweep_in_room(turning), turning);
  const auto spinning = [](LogTime t) { return SE2d(1.0, 1.0, Angle::radians(3.0 * since(t))); };
  expect_instantaneous(sweep_in_room(spinning), spinning);
  const auto sliding = [](LogTime t) { return SE2d(0.0, 2.0 * since(t), 1_rad); };
  expect_instantaneous(sweep_in_room(sliding), sliding);
  expect_instantaneous(sweep_in_room(turning, empty_sweep(-empty_sweep().time_increment)), turning);
}

TEST(Deskew, WithoutItTheWallsAreDistorted) {
  const LaserScan sweep = sweep_in_room(turning);
  const SE2d then = turning(kAt);
  double worst = 0.0;
  for (std::size_t i = 0; i < kBeams; ++i) {
    const SO2d beam(then.heading() + sweep.bearing(i));
    const double expected = to_wall(then.translation(), beam * Eigen::Vector2d::UnitX());
    worst = std::max(worst, std::abs(static_cast<double>(sweep.ranges_m[i]) - expected));
  }
  EXPECT_GT(worst, 0.2);  // the turn alone is 8° at the ends: 0.14 of the distance across
}

TEST(Deskew, PointsWithTimesOfTheirOwnMoveToo) {
  const LaserScan sweep = sweep_in_room(turning);
  std::vector<LogTime> times;
  std::vector<Eigen::Vector2d> points;
  for (std::size_t i = 0; i < kBeams; ++i) {
    times.push_back(sweep.beam_time(i));
    points.emplace_back(detail::beam_end(sweep, i).head<2>());
  }
  const LogTime end = sweep.end_time();
  ASSERT_TRUE(deskew(times, turning, end, points));
  for (const Eigen::Vector2d& p : points) {
    const Eigen::Vector2d q = turning(end) * p;
    const double off = std::min(std::abs(std::abs(q.x()) - 3.0), std::abs(std::abs(q.y()) - 2.0));
    EXPECT_LT(off, kRounding_m);
  }
}

TEST(Deskew, WithoutMotionPointsAreIdentical) {
  const auto still = [](LogTime) { return SE2d(1.0, -2.0, 0.7_rad); };
  LaserScan sweep = sweep_in_room([](LogTime) { return SE2d(0.3, 0.1, 0.2_rad); });
  sweep.ranges_m[5] = 20.0F;  // no return
  sweep.ranges_m[6] = std::numeric_limits<float>::quiet_NaN();
  LaserScan instant;
  ASSERT_TRUE(deskew(sweep, still, sweep.time, instant));
  for (std::size_t i = 0; i < kBeams; ++i) {
    EXPECT_EQ(instant.bearing(i).radians(), sweep.bearing(i).radians());
    EXPECT_EQ(instant.returned(i), sweep.returned(i));
    if (sweep.returned(i)) {
      EXPECT_EQ(instant.ranges_m[i], sweep.ranges_m[i]);
    }
  }
  EXPECT_EQ(instant.ranges_m[5], 20.0F);
  const std::vector<LogTime> times{kAt, kAt};
  std::vector<Eigen::Vector2d> points{{0.1, 0.7}, {1.0 / 3.0, 9.0}};
  const auto before = points;
  ASSERT_TRUE(deskew(times, still, kAt, points));
  EXPECT_EQ(points, before);
}

// A head that nods and turns in the room, whose walls are upright: the level scan of the sweep
// shows them where they are from the head's place then. Bins of 0.1° move a point by r · 0.05° = 3
// mm.
TEST(Deskew, ASweepFromASwayingHeadIsTheLevelScan) {
  const auto head = [](LogTime time) {
    const double t = since(time);
    const SO3d q = SO3d::exp(Eigen::Vector3d(0, 0, 2.0 * t)) *
                   SO3d::exp(Eigen::Vector3d(0.1 - 0.8 * t, 0.15 + 1.1 * t, 0));
    return SE3d(Eigen::Vector3d(0.5 + 1.2 * t, 0.2, 0.1 * t), q);
  };
  LaserScan sweep = empty_sweep();
  for (std::size_t i = 0; i < kBeams; ++i) {
    const SE3d pose = head(sweep.beam_time(i));
    const double b = sweep.bearing(i).radians();
    const Eigen::Vector3d d = pose.rotation() * Eigen::Vector3d(std::cos(b), std::sin(b), 0.0);
    sweep.ranges_m[i] = static_cast<float>(to_wall(pose.translation().head<2>(), d.head<2>()));
  }
  LaserScan level;
  ASSERT_TRUE(level_scan(sweep, head, kAt, level));
  const Eigen::Vector2d then = head(kAt).translation().head<2>();
  std::size_t points = 0;
  for (std::size_t i = 0; i < level.ranges_m.size(); ++i) {
    if (!level.returned(i)) continue;
    ++points;
    const Eigen::Vector2d p = then + detail::beam_end(level, i).head<2>();
    const double off = std::min(std::abs(std::abs(p.x()) - 3.0), std::abs(std::abs(p.y()) - 2.0));
    EXPECT_LT(off, 4e-3) << i;
  }
  EXPECT_GT(points, 300U);
}

TEST(Deskew, ALevelScanOfOneInstantIsThatOfTheAttitude) {
  const LaserScan scan = sweep_in_room(turning, empty_sweep(Duration::zero()));
  const SO3d q = SO3d::exp(Eigen::Vector3d(0.1, -0.2, 0.3));
  LaserScan level;
  ASSERT_TRUE(level_scan(
      scan, [&](LogTime) { return SE3d(Eigen::Vector3d(1, 2, 3), q); }, kAt, level));
  const LaserScan expected = level_scan(scan, q);
  for (std::size_t i = 0; i < expected.ranges_m.size(); ++i)
    if (expected.returned(i)) {
      EXPECT_EQ(level.ranges_m[i], expected.ranges_m[i]);
    }
}

template <class Motion>
std::string why(const LaserScan& scan, const Motion& motion) {
  LaserScan instant;
  const auto done = deskew(scan, motion, scan.time, instant);
  return done ? "" : done.error().message;
}

TEST(Deskew, AMotionThatDoesNotCoverTheSweepIsNamed) {
  const auto ends = [](LogTime time) -> std::optional<SE2d> {
    if (since(time) > 0.0452) return std::nullopt;
    return turning(time);
  };
  const LaserScan sweep = sweep_in_room(turning);
  EXPECT_THAT(why(sweep, ends), HasSubstr("the motion does not cover the sweep: not known at beam "
                                          "271, 45.500000 ms after the instant"));
  EXPECT_THAT(why(sweep, [](LogTime) { return std::optional<SE2d>(); }),
              HasSubstr("not known at the scan's instant"));
}

TEST(Deskew, BadInputIsNamed) {
  const LaserScan sweep = sweep_in_room(turning);
  EXPECT_THAT(
      why(sweep, [](LogTime time) { return SE2d(since(time) < -0.08 ? kNan : 0.0, 0.0, Angle()); }),
      HasSubstr("the motion is not finite at beam 0, 90.0"));
  EXPECT_THAT(why(sweep, [](LogTime) { return SE2d(0.0, 0.0, Angle::radians(kNan)); }),
              HasSubstr("the motion is not finite at the scan's instant"));
  LaserScan long_sweep = sweep;
  long_sweep.time_increment = from_seconds(0.1);
  EXPECT_THAT(why(long_sweep, turning), HasSubstr("takes 36.000000 s: 10 s or more"));
  long_sweep.time_increment = Duration::max();
  EXPECT_THAT(why(long_sweep, turning), HasSubstr("10 s or more"));
  LaserScan bent = sweep;
  bent.bearing_step = Angle::radians(kNan);
  EXPECT_THAT(why(bent, turning), HasSubstr("the bearing of beam 0 is not finite"));
  LaserScan none = empty_sweep();
  none.ranges_m.clear();
  EXPECT_EQ(why(none, turning), "");
}

TEST(Deskew, PointsInDisorderAreNamed) {
  const auto why = [](std::vector<LogTime> times, std::vector<Eigen::Vector2d> points) {
    const auto done = deskew(times, turning, kAt, points);
    return done ? "" : done.error().message;
  };
  const LogTime later = kAt + from_seconds(0.01);
  EXPECT_EQ(why({kAt, kAt, later}, {{1, 2}, {1, 2}, {1, 2}}), "");
  EXPECT_EQ(why({}, {}), "");
  EXPECT_EQ(why({kAt, later, kAt}, {{1, 2}, {1, 2}, {1, 2}}),
            "point 2 is earlier than the one before it");
  EXPECT_EQ(why({kAt, later}, {{1, 2}, {1, kNan}}), "point 1 is not finite");
  EXPECT_EQ(why({kAt}, {{1, 2}, {1, 2}}), "2 points with 1 times");
}

TEST(PoseHistory, GivesThePoseBetweenThoseAdded) {
  PoseHistory<SE2d> poses;
  EXPECT_FALSE(poses(kAt));
  for (int k = 0; k <= 60; ++k) {
    const LogTime time = kAt + from_seconds(0.01 * (k - 30));
    ASSERT_TRUE(poses.add(time, turning(time)));
  }
  // On one circle the twist is constant: interpolation is exact.
  for (double t = -0.31; t < 0.311; t += 0.0007) {
    const LogTime time = kAt + from_seconds(t);
    const auto pose = poses(time);
    ASSERT_TRUE(pose) << t;
    EXPECT_LT(pose->minus(turning(time)).norm(), 1e-9);
  }
  EXPECT_FALSE(poses(kAt + from_seconds(0.33)));
  EXPECT_FALSE(poses(kAt - from_seconds(0.33)));
  expect_instantaneous(sweep_in_room(turning), [&](LogTime time) { return *poses(time); });
  poses.clear();
  EXPECT_FALSE(poses(kAt));
}

TEST(PoseHistory, RefusesDisorderAndKeepsTheLatest) {
  PoseHistory<SE3d> poses;
  ASSERT_TRUE(poses.add(kAt, SE3d()));
  EXPECT_THAT(poses.add(kAt, SE3d()).error().message, HasSubstr("not later"));
  EXPECT_THAT(poses.add(kAt - Duration(1), SE3d()).error().message, HasSubstr("not later"));
  const SE3d nowhere(Eigen::Vector3d(0, kNan, 0), SO3d());
  EXPECT_THAT(poses.add(kAt + Duration(1), nowhere).error().message, HasSubstr("not finite"));
  for (int k = 1; k < 2000; ++k) ASSERT_TRUE(poses.add(kAt + from_seconds(0.01 * k), SE3d()));
  EXPECT_FALSE(poses(kAt));
  EXPECT_TRUE(poses(kAt + from_seconds(19.99)));
  EXPECT_TRUE(poses(kAt + from_seconds(17.5)));
  ASSERT_TRUE(poses.add(kAt + from_seconds(30.0), SE3d()));
  EXPECT_FALSE(poses(kAt + from_seconds(25.0)));  // a gap
}

}  // namespace
}  // namespace wayfare
