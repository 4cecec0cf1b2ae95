// Scans, point sets, trajectories and thinning of what a broken device or file contains.

#include <cmath>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include <wayfare/core/random.hpp>
#include <wayfare/sensors/point_set.hpp>
#include <wayfare/sensors/recording.hpp>
#include <wayfare/sensors/scans.hpp>
#include <wayfare/sensors/trajectory.hpp>

#include "abuse/abuse.hpp"

namespace wayfare::tests {
namespace {

constexpr float kNanF = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfF = std::numeric_limits<float>::infinity();

LaserScan scan_of(std::vector<float> ranges) {
  return {LogTime{}, Angle::degrees(-90), Angle::degrees(1), 0.1F, 30.0F, std::move(ranges)};
}
const std::vector<float> kBroken{kNanF, kInfF, -kInfF, -1.0F, 0.0F, 1e30F, 30.0F, 0.1F, 5.0F};

TEST(LaserScanAbuse, OnlyRangesWithinTheLimitsReturn) {
  const LaserScan scan = scan_of(kBroken);
  std::size_t returned = 0;
  for (std::size_t i = 0; i < scan.ranges_m.size(); ++i) returned += scan.returned(i) ? 1 : 0;
  EXPECT_EQ(returned, 2U);
  EXPECT_EQ(end_points(scan).size(), 2U);
  LaserScan limits = scan;
  limits.max_range_m = kNanF;
  EXPECT_TRUE(end_points(limits).empty());
  limits.max_range_m = kInfF;
  EXPECT_EQ(end_points(limits).size(), 4U);  // infinity itself does not return
  EXPECT_TRUE(end_points(scan_of({})).empty());
}

TEST(LaserScanAbuse, LevelScansDropWhatHasNoPlace) {
  for (const double odd : kNotFinite) {
    const LaserScan level = level_scan(scan_of(kBroken), SO3d::exp({odd, 0.0, 0.0}));
    for (const float r : level.ranges_m) EXPECT_TRUE(std::isnan(r));
  }
  EXPECT_EQ(level_scan(scan_of({}), SO3d()).ranges_m.size(), 3600U);
  LaserScan turned = scan_of(kBroken);
  turned.first_bearing = Angle::radians(1e9);
  turned.bearing_step = Angle::radians(-1e9);
  for (const std::size_t beams : {std::size_t{1}, std::size_t{7}, std::size_t{1'000'000}}) {
    const LaserScan level = level_scan(turned, SO3d(), {.beams = beams});
    ASSERT_EQ(level.ranges_m.size(), beams);
    std::size_t kept = 0;
    for (const float r : level.ranges_m) kept += std::isnan(r) ? 0 : 1;
    EXPECT_GE(kept, 1U);
    EXPECT_LE(kept, 2U);
  }
}

TEST(LaserScanDeathTest, ALevelScanHasBeams) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  for (const std::size_t beams : {std::size_t{0}, std::size_t{1'000'000'000}})
    EXPECT_DEATH((void)level_scan(scan_of({}), SO3d(), {.beams = beams}), "million beams");
}

std::vector<float> contents(PointSet& points) {
  std::vector<float> all;
  points.push_back({1.0F, 2.0F});
  for (std::size_t i = 0; i < points.size(); ++i) {
    all.push_back(points.x_m()[i]);
    all.push_back(points.y_m()[i]);
  }
  all.insert(all.end(), points.padded_x_m().begin(), points.padded_x_m().end());
  all.push_back(points.max_norm_m());
  return all;
}

TEST(PointSetAbuse, LivesAsAValueAndIsEmptyWhenMovedFrom) {
  PointSet points;
  expect_value_semantics(points, contents);
  for (int i = 0; i < 37; ++i) points.push_back({float(i), -float(i)});
  expect_value_semantics(points, contents);
  PointSet taken = std::move(points);
  EXPECT_EQ(taken.size(), 37U);
  EXPECT_TRUE(points.empty());  // NOLINT(bugprone-use-after-move): what is documented of it
  EXPECT_EQ(points.x_m().size(), 0U);
  EXPECT_EQ(points.padded_y_m().size(), 0U);
  EXPECT_EQ(points.max_norm_m(), 0.0F);
  points.push_back({3.0F, 4.0F});
  EXPECT_EQ(points.size(), 1U);
  EXPECT_EQ(points.padded_x_m().size(), PointSet::kLanes);
  EXPECT_EQ(points.max_norm_m(), 5.0F);
}

TEST(PointSetAbuse, ThinsWhatIsNotFinite) {
  PointSet points;
  for (const float x : {kNanF, kInfF, -kInfF, 1e30F, 1.0F, 1.0F, 2.0F}) points.push_back({x, 0.0F});
  EXPECT_EQ(thin(points, 0.1F, 100.0F).size(), 2U);
  EXPECT_TRUE(thin(points, 0.1F, kNanF).empty());
  EXPECT_TRUE(thin(points, 0.1F, -1.0F).empty());
  EXPECT_TRUE(thin(PointSet{}, 0.1F, 1.0F).empty());
  EXPECT_EQ(thin(points, kInfF, 100.0F).size(), 1U);
}

Recording of_scans(std::size_t n) {
  Recording recording;
  for (std::size_t i = 0; i < n; ++i)
    recording.scans.push_back(scan_of(std::vector<float>(181, 1.0F + static_cast<float>(i))));
  return recording;
}

TEST(ThinningAbuse, AnyNumbersEnd) {
  constexpr std::size_t kMost = std::numeric_limits<std::size_t>::max();
  for (const std::size_t every : {std::size_t{0}, std::size_t{1}, std::size_t{3}, kMost})
    for (const std::size_t beams : {std::size_t{0}, std::size_t{1}, std::size_t{1000}, kMost})
      for (const double number : {0.0, -1.0, 1e-300, 1e9, kHuge, kNan, kInf}) {
        Recording recording = of_scans(7);
        thin(recording, {every, beams, number, number});
        ASSERT_EQ(recording.scans.size(), every <= 1 ? 7U : every == 3 ? 3U : 1U);
        for (const LaserScan& scan : recording.scans) ASSERT_LE(scan.ranges_m.size(), 181U);
        Recording empty;
        thin(empty, {every, beams, number, number});
        EXPECT_TRUE(empty.scans.empty());
      }
  Recording same = of_scans(2);
  thin(same, {0, 0});
  EXPECT_EQ(same.scans[0].ranges_m.size(), 181U);
  EXPECT_EQ(same.scans[0].bearing_step.radians(), Angle::degrees(1).radians());
}

StampedPose pose_of(std::int64_t ns, double x) {
  return {LogTime::from_nanoseconds(ns), Transform2<frame::Map, frame::Base>(SE2d(x, 0, Angle{}))};
}

TEST(TrajectoryAbuse, AnyTimesGiveAPoseBetweenTheNeighboursOrNone) {
  constexpr auto kFirst = std::numeric_limits<std::int64_t>::min();
  constexpr auto kLast = std::numeric_limits<std::int64_t>::max();
  const Trajectory whole{pose_of(kFirst, 0.0), pose_of(kLast, 1.0)};
  for (const std::int64_t ns : {kFirst, kFirst + 1, std::int64_t{0}, kLast - 1, kLast}) {
    const auto pose = pose_at(whole, LogTime::from_nanoseconds(ns));
    ASSERT_TRUE(pose);
    EXPECT_TRUE(pose->x() >= 0.0 && pose->x() <= 1.0) << pose->x();
  }
  EXPECT_FALSE(pose_at({}, LogTime{}));
  EXPECT_FALSE(pose_at(whole, LogTime{}, {.largest_gap = std::chrono::seconds(1)}));
  EXPECT_FALSE(pose_at(Trajectory{pose_of(5, 0.0)}, LogTime{}));
  const Trajectory twice{pose_of(0, 0.0), pose_of(0, 1.0), pose_of(0, 2.0)};
  EXPECT_EQ(pose_at(twice, LogTime{})->x(), 0.0);
  EXPECT_TRUE(as_trajectory({}).empty());
}

TEST(TrajectoryAbuse, RandomTimesAsByASearchOfAll) {
  Rng rng(7);
  for (int run = 0; run < 500; ++run) {
    Trajectory t;
    std::int64_t ns = -static_cast<std::int64_t>(rng.below(1'000'000));
    for (std::size_t i = rng.below(12); i > 0; --i)
      t.push_back(pose_of(ns += static_cast<std::int64_t>(rng.below(5) * 1000), rng.normal()));
    const GapLimit limit{Duration(rng.below(3000)), Duration(rng.below(1500))};
    const LogTime time =
        LogTime::from_nanoseconds((t.empty() ? 0 : t[0].time.nanoseconds()) +
                                  static_cast<std::int64_t>(rng.below(30000)) - 3000);
    std::optional<double> expected;
    for (std::size_t i = t.size(); i-- > 0;) {
      if (t[i].time == time) expected = t[i].T_map_base.raw().x();
      if (i + 1 == t.size() || !(t[i].time < time && time < t[i + 1].time)) continue;
      const Duration before = time - t[i].time, after = t[i + 1].time - time;
      if (before + after > limit.largest_gap && std::min(before, after) > limit.near) continue;
      const double u = to_seconds(before) / to_seconds(before + after);
      expected = (1.0 - u) * t[i].T_map_base.raw().x() + u * t[i + 1].T_map_base.raw().x();
    }
    const auto pose = pose_at(t, time, limit);
    ASSERT_EQ(pose.has_value(), expected.has_value()) << run;
    if (pose) {
      ASSERT_NEAR(pose->x(), *expected, 1e-12) << run;
    }
  }
}

TEST(ScansAbuse, TwoThreadsSeeTheSame) {
  const auto both = in_two_threads([](int) {
    Recording recording = of_scans(20);
    thin(recording, {2, 3, 15.0, 120.0});
    std::vector<float> all;
    for (const LaserScan& scan : recording.scans) {
      const LaserScan level = level_scan(scan, SO3d::exp({0.02, 0.01, 0.0}));
      PointSet points = thin(end_points(level), 0.05F, 20.0F);
      const auto part = contents(points);
      all.insert(all.end(), part.begin(), part.end());
    }
    return all;
  });
  EXPECT_EQ(both[0], both[1]);
}

}  // namespace
}  // namespace wayfare::tests
