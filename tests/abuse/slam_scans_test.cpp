// The systems that take one scan at a time (graph, Hector, submap and pedestrian SLAM): scans and
// odometry that are none, the life of the objects, and options at their limits.

#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "abuse/slam_support.hpp"

namespace wayfare::tests {
namespace {

template <class Driver>
class AbusedSlam : public ::testing::Test {};
using Drivers = ::testing::Types<GraphDriver, HectorDriver, SubmapDriver, PedestrianDriver>;
TYPED_TEST_SUITE(AbusedSlam, Drivers);

/// The systems that take odometry; the walker's have steps.
template <class Driver>
class AbusedOdometry : public ::testing::Test {};
using OdometryDrivers = ::testing::Types<GraphDriver, HectorDriver, SubmapDriver>;
TYPED_TEST_SUITE(AbusedOdometry, OdometryDrivers);

struct Change {
  const char* what;
  std::function<void(LaserScan&, std::optional<Odometry>&)> apply;
};

/// Refused by every system.
const std::vector<Change>& refused() {
  static const std::vector<Change> all = {
      {"no beams", [](LaserScan& s, auto&) { s.ranges_m.clear(); }},
      {"NaN bearing", [](LaserScan& s, auto&) { s.first_bearing = Angle::radians(kNan); }},
      {"infinite bearing", [](LaserScan& s, auto&) { s.first_bearing = Angle::radians(kInf); }},
      {"NaN step", [](LaserScan& s, auto&) { s.bearing_step = Angle::radians(kNan); }},
      {"infinite step", [](LaserScan& s, auto&) { s.bearing_step = Angle::radians(-kInf); }},
      {"the last bearing overflows",
       [](LaserScan& s, auto&) { s.bearing_step = Angle::radians(1e307); }},
      {"earlier", [](LaserScan& s, auto&) { s.time = s.time - Duration(3'000'000'000); }},
      {"the earliest time",
       [](LaserScan& s, auto&) {
         s.time = LogTime::from_nanoseconds(std::numeric_limits<std::int64_t>::min());
       }},
  };
  return all;
}

/// Refused by the systems with odometry.
const std::vector<Change>& refused_odometry() {
  static const std::vector<Change> all = {
      {"NaN x", [](auto&, auto& o) { o = Odometry(SE2d(kNan, 0.0, Angle{})); }},
      {"infinite y", [](auto&, auto& o) { o = Odometry(SE2d(0.0, kInf, Angle{})); }},
      {"NaN heading", [](auto&, auto& o) { o = Odometry(SE2d(0.0, 0.0, Angle::radians(kNan))); }},
      {"farther than cells are numbered",
       [](auto&, auto& o) { o = Odometry(SE2d(1e300, 0.0, Angle{})); }},
      {"1e9 m away", [](auto&, auto& o) { o = Odometry(SE2d(0.0, -1e9, Angle{})); }},
  };
  return all;
}

/// Accepted, whatever the scan is worth.
const std::vector<Change>& accepted() {
  static const std::vector<Change> all = {
      {"one beam", [](LaserScan& s, auto&) { s.ranges_m.resize(1); }},
      {"two beams", [](LaserScan& s, auto&) { s.ranges_m.resize(2); }},
      {"no returns", [](LaserScan& s, auto&) { s.ranges_m.assign(kBeams, 20.0F); }},
      {"NaN", [](LaserScan& s, auto&) { s.ranges_m.assign(kBeams, NAN); }},
      {"infinite ranges that count as returns",
       [](LaserScan& s, auto&) {
         s.max_range_m = INFINITY;
         s.ranges_m.assign(kBeams, 1e38F);
       }},
      {"all at the laser",
       [](LaserScan& s, auto&) {
         s.min_range_m = 0.0F;
         s.ranges_m.assign(kBeams, 0.0F);
       }},
      {"negative ranges",
       [](LaserScan& s, auto&) {
         s.min_range_m = -5.0F;
         for (float& r : s.ranges_m) r = -r;
       }},
      {"limits exchanged", [](LaserScan& s, auto&) { std::swap(s.min_range_m, s.max_range_m); }},
      {"limits NaN", [](LaserScan& s, auto&) { s.min_range_m = s.max_range_m = NAN; }},
      {"every beam in one direction", [](LaserScan& s, auto&) { s.bearing_step = Angle{}; }},
      {"many turns", [](LaserScan& s, auto&) { s.first_bearing = Angle::radians(1e9); }},
      {"40000 beams",
       [](LaserScan& s, auto&) {
         s.ranges_m.resize(40'000, 2.0F);
         s.bearing_step = Angle::degrees(360.0 / 40'000);
       }},
      {"no odometry", [](auto&, auto& o) { o.reset(); }},
      {"odometry elsewhere", [](auto&, auto& o) { o = Odometry(SE2d(1e6, -1e6, 3_rad)); }},
      {"the same time", [](LaserScan& s, auto&) { s.time = s.time - Duration(200'000'000); }},
      {"a nanosecond later", [](LaserScan& s, auto&) { s.time = s.time - Duration(199'999'999); }},
  };
  return all;
}

template <class Driver>
void drive(Driver& driver, int from, int to) {
  for (int k = from; k < to; ++k)
    EXPECT_TRUE(driver.add(scan_of_drive(k), odometry_of_drive(k))) << k;
}

TYPED_TEST(AbusedSlam, WithoutScansIsEmpty) {
  TypeParam driver;
  EXPECT_TRUE(driver.trajectory().empty());
  EXPECT_FALSE(driver.map().bounds());
  EXPECT_TRUE(driver.finish());
  EXPECT_TRUE(driver.finish());
  EXPECT_EQ(driver.scans(), 0U);
  drive(driver, 0, 2);
  EXPECT_EQ(driver.trajectory().size(), 2U);
}

// Before the first scan and in mid-run; the run then is as if there had been none.
TYPED_TEST(AbusedSlam, RefusesWhatIsNoScanAndIsUnchanged) {
  std::vector<Change> changes = refused();
  if (!std::is_same_v<TypeParam, PedestrianDriver>)
    changes.insert(changes.end(), refused_odometry().begin(), refused_odometry().end());
  TypeParam abused, spared;
  const auto abuse = [&](int k) {
    for (const Change& change : changes) {
      if (k == 0 && std::string(change.what).find("earl") != std::string::npos) continue;
      LaserScan scan = scan_of_drive(k);
      std::optional<Odometry> odometry = odometry_of_drive(k);
      change.apply(scan, odometry);
      const auto outcome = abused.add(scan, odometry);
      ASSERT_FALSE(outcome) << change.what;
      EXPECT_FALSE(outcome.error().message.empty());
    }
  };
  for (int k = 0; k < 30; ++k) {
    if (k == 0 || k == 1 || k == 14) abuse(k);
    drive(abused, k, k + 1);
    drive(spared, k, k + 1);
  }
  EXPECT_TRUE(abused.finish() && spared.finish());
  EXPECT_EQ(numbers_of(abused), numbers_of(spared));
}

// As the first scan, and in mid-run: every pose is finite, one for each scan, and a run that was
// merely disturbed recovers.
TYPED_TEST(AbusedSlam, AcceptsOddScans) {
  for (const Change& change : accepted())
    for (const int at : {0, 1, 12}) {
      SCOPED_TRACE(std::string(change.what) + " at scan " + std::to_string(at));
      if (at == 0 && std::string(change.what) == "odometry elsewhere") continue;
      TypeParam driver;
      drive(driver, 0, at);
      LaserScan scan = scan_of_drive(at);
      std::optional<Odometry> odometry = odometry_of_drive(at);
      change.apply(scan, odometry);
      EXPECT_TRUE(driver.add(scan, odometry));
      drive(driver, at + 1, at + 8);
      EXPECT_TRUE(driver.finish());
      const std::vector<double> numbers = numbers_of(driver.trajectory());
      EXPECT_EQ(numbers.size(), 5 * static_cast<std::size_t>(at + 8));
      EXPECT_TRUE(all_finite(numbers));
      EXPECT_LT(driver.map().tiles().tile_count(), 5000U);
    }
}

TYPED_TEST(AbusedSlam, TimesAtTheLimits) {
  using Limits = std::numeric_limits<std::int64_t>;
  TypeParam driver;
  int k = 0;
  for (const std::int64_t ns :
       {Limits::min(), Limits::min() + 1, std::int64_t{0}, std::int64_t{1'000'000'000'000'000'000},
        Limits::max() - 1, Limits::max(), Limits::max()}) {
    const LogTime time = LogTime::from_nanoseconds(ns);
    EXPECT_TRUE(driver.add(scan_of_room(time, pose_of_drive(k)), odometry_of_drive(k)));
    EXPECT_TRUE(driver.add(scan_of_room(time, pose_of_drive(k)), std::nullopt));
    ++k;
  }
  EXPECT_TRUE(driver.finish());
  EXPECT_EQ(driver.trajectory().size(), 14U);
  EXPECT_TRUE(all_finite(numbers_of(driver)));
}

// Odometry that leaps farther each time, by less than is refused.
TYPED_TEST(AbusedSlam, OdometryThatLeaps) {
  TypeParam driver;
  for (int k = 0; k < 25; ++k) {
    const double sign = k % 2 == 0 ? 1.0 : -1.0;
    const Odometry leaping(SE2d(sign * std::pow(10.0, 0.25 * k), 0.0, Angle::radians(2.0 * k)));
    (void)driver.add(scan_of_drive(k), leaping);
    LaserScan blind = scan_of_drive(k);
    blind.ranges_m.assign(kBeams, NAN);
    (void)driver.add(blind, Odometry(SE2d(0.0, -sign * std::pow(10.0, 0.25 * k), Angle{})));
    (void)driver.add(blind, std::nullopt);
  }
  EXPECT_TRUE(driver.finish());
  EXPECT_TRUE(all_finite(numbers_of(driver.trajectory())));
  EXPECT_LT(driver.map().tiles().tile_count(), 20'000U);
}

// The first two scans with almost the same stamp, from places a decimetre apart: that is no
// velocity of the robot. It does not turn: a turn as fast would keep the prediction on a circle.
TYPED_TEST(AbusedSlam, FirstStampsANanosecondApart) {
  TypeParam driver;
  for (int k = 0; k < 20; ++k) {
    const LogTime time = k == 0 ? time_of_drive(1) - Duration(1) : time_of_drive(k);
    EXPECT_TRUE(driver.add(scan_of_room(time, SE2d(2.0 + 0.1 * k, 1.6, Angle{})), std::nullopt));
  }
  const Trajectory path = driver.trajectory();
  const SE2d moved = path.front().T_map_base.raw().inverse() * path.back().T_map_base.raw();
  EXPECT_LT((moved.translation() - Eigen::Vector2d(1.9, 0.0)).norm(), 0.2);
}

// Odometry that is elsewhere for some scans without returns, and comes back.
TYPED_TEST(AbusedOdometry, FindsBackAfterLeaps) {
  TypeParam driver;
  drive(driver, 0, 10);
  for (int k = 10; k < 40; ++k) {
    LaserScan blind = scan_of_drive(k);
    blind.ranges_m.assign(kBeams, NAN);
    const SE2d elsewhere(k % 2 == 0 ? 4e3 : -4e3, 0.0, 1_rad);
    EXPECT_TRUE(driver.add(blind, Odometry(k == 39 ? pose_of_drive(k) : elsewhere)));
  }
  for (int k = 40; k < 50; ++k) {
    const auto outcome = driver.add(scan_of_drive(k), odometry_of_drive(k));
    ASSERT_TRUE(outcome);
    EXPECT_TRUE(outcome->matched || k <= 42) << k;
  }
}

TYPED_TEST(AbusedSlam, LivesAsAValue) {
  const auto make = [] {
    TypeParam driver;
    drive(driver, 0, 6);
    return driver;
  };
  const auto probe = [](TypeParam& driver) {
    drive(driver, 6, 12);
    return numbers_of(driver);
  };
  expect_move_semantics(make, probe);
}

TYPED_TEST(AbusedSlam, TwoThreads) {
  const auto results = in_two_threads([](int) {
    TypeParam driver;
    drive(driver, 0, 20);
    EXPECT_TRUE(driver.finish());
    return numbers_of(driver);
  });
  EXPECT_EQ(results[0], results[1]);
}

TYPED_TEST(AbusedSlam, Recordings) {
  const auto error = [](const auto& result) { return result ? "" : result.error().message; };
  Recording recording;
  EXPECT_EQ(error(TypeParam::run(recording)), "the recording has no scans");
  recording.scans = {scan_of_drive(0)};
  EXPECT_EQ(error(TypeParam::run(recording)), "");
  for (int k = 1; k < 8; ++k) recording.scans.push_back(scan_of_drive(k));
  std::swap(recording.scans[2], recording.scans[5]);
  EXPECT_EQ(error(TypeParam::run(recording)), "");
  int calls = 0;
  EXPECT_EQ(error(TypeParam::run(recording, [&](double) { return ++calls < 1; })), "");
  EXPECT_EQ(calls, 1);
  for (int k = 0; k < 8; ++k) recording.odometry.push_back({time_of_drive(7 - k), Odometry()});
  EXPECT_EQ(error(TypeParam::run(recording)), "") << "odometry in reverse order";
  for (auto& o : recording.odometry) o = {time_of_drive(3), Odometry(pose_of_drive(3))};
  EXPECT_EQ(error(TypeParam::run(recording)), "") << "odometry of one time";
  for (auto& o : recording.odometry) o.T_odom_base = Odometry(SE2d(kNan, 0.0, Angle{}));
  if (!std::is_same_v<TypeParam, PedestrianDriver>) {
    EXPECT_NE(error(TypeParam::run(recording)), "") << "odometry that is not finite";
  }
  for (LaserScan& scan : recording.scans) scan.ranges_m.clear();
  EXPECT_NE(error(TypeParam::run(recording)), "");
}

}  // namespace
}  // namespace wayfare::tests
