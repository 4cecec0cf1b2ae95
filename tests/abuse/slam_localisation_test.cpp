// Monte-Carlo localisation and its map: poses, scans and odometry that are none, and times near the
// limits.

#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "abuse/slam_localisation_support.hpp"

namespace wayfare::tests {
namespace {

Localiser localiser_at_start(const LocalisationOptions& options = quick_options()) {
  Localiser localiser(map_of_room(), options, 1);
  EXPECT_TRUE(localiser.start_at(start_of_drive()));
  return localiser;
}

TEST(AbusedLocalisationMap, OddGrids) {
  EXPECT_FALSE(LocalisationMap::make(OccupancyGrid()));
  OccupancyGrid one;
  one.update({0, 0}, LogOdds::from_nats(9.0));
  EXPECT_FALSE(LocalisationMap::make(one)) << "no free cell";
  one.update({8, 0}, LogOdds::from_nats(-9.0));
  EXPECT_TRUE(LocalisationMap::make(one));
  const OccupancyGrid empty;
  EXPECT_FALSE(LocalisationMap::make(one, {}, &empty)) << "an empty radar map";
  EXPECT_TRUE(LocalisationMap::make(one, {}, &one)) << "one grid as both";
  for (const int far : {1 << 20, kMaxCell, -kMaxCell}) {
    OccupancyGrid wide = one;
    wide.update({far, far}, LogOdds::from_nats(9.0));
    EXPECT_FALSE(LocalisationMap::make(wide)) << far;
    EXPECT_FALSE(LocalisationMap::make(one, {}, &wide)) << far;
  }
}

TEST(AbusedLocaliser, RefusesWhatIsNoneAndIsUnchanged) {
  Localiser abused = localiser_at_start(), spared = localiser_at_start();
  std::vector<double> seen[2];
  const auto unchanged = [&](const auto& result, const char* what) {
    EXPECT_FALSE(result) << what;
  };
  for (int k = 0; k < 12; ++k) {
    for (const double bad : kNotFinite) {
      Gaussian<SE2d> pose = start_of_drive();
      pose.mean = SE2d(bad, 0.0, Angle{});
      unchanged(abused.start_at(pose), "x");
      pose.mean = SE2d(0.0, 0.0, Angle::radians(bad));
      unchanged(abused.start_at(pose), "heading");
      for (int i = 0; i < 9; ++i) {
        pose = start_of_drive();
        pose.covariance(i / 3, i % 3) = bad;
        unchanged(abused.start_at(pose), "covariance");
      }
      LaserScan scan = scan_of_drive(k);
      scan.first_bearing = Angle::radians(bad);
      unchanged(abused.add_scan(scan, {}), "bearing");
      scan = scan_of_drive(k);
      scan.bearing_step = Angle::radians(bad);
      unchanged(abused.add_scan(scan, {}), "step");
      PointSet points = points_of_drive(k);
      points.push_back({static_cast<float>(bad), 0.0F});
      unchanged(abused.add_radar(time_of_drive(k), points, {}), "detection");
    }
    for (int i = 0; i < 3; ++i) {
      const int j = (i + 1) % 3;
      Gaussian<SE2d> pose = start_of_drive();
      pose.covariance(i, j) = pose.covariance(j, i) = 0.011;
      unchanged(abused.start_at(pose), "indefinite");
      pose = start_of_drive();
      pose.covariance(i, j) = 0.009;
      unchanged(abused.start_at(pose), "not symmetric");
      pose.covariance.setZero();
      pose.covariance(i, j) = pose.covariance(j, i) = 0.01;
      unchanged(abused.start_at(pose), "covariances without variances");
    }
    LaserScan scan = scan_of_drive(k);
    scan.bearing_step = Angle::radians(1e307);
    unchanged(abused.add_scan(scan, {}), "the last bearing overflows");
    if (k > 0) {
      unchanged(abused.add_scan(scan_of_drive(k - 1), {}), "late");
      unchanged(abused.add_motion(time_of_drive(k - 1), {}), "late motion");
      unchanged(abused.add_radar(time_of_drive(k) - Duration(200'000'001), points_of_drive(k), {}),
                "late detections");
    }
    int which = 0;
    for (Localiser* each : {&abused, &spared}) {
      const auto outcome = each->add_scan(scan_of_drive(k), odometry_of_drive(k));
      ASSERT_TRUE(outcome);
      append(seen[which++], *outcome);
    }
  }
  EXPECT_EQ(seen[0], seen[1]);
  EXPECT_EQ(numbers_of(abused), numbers_of(spared));
}

// Singular, immense and far: a start anywhere in the plane is no error, and no pose is lost.
TEST(AbusedLocaliser, StartsBeyondUse) {
  Eigen::Matrix3d along = Eigen::Matrix3d::Zero();
  along(0, 0) = 0.01;
  const Eigen::Vector3d v(0.1, -0.2, 0.3);
  const auto run = [](const Gaussian<SE2d>& start, ScanLikelihood model) {
    LocalisationOptions options = quick_options();
    options.model = model;
    Localiser localiser(map_of_room(), options, 1);
    const auto ok = localiser.start_at(start);
    for (int k = 0; k < 12; ++k)
      EXPECT_TRUE(localiser.add_scan(scan_of_drive(k), odometry_of_drive(k)));
    EXPECT_TRUE(all_finite(numbers_of(localiser)));
    return ok.has_value();
  };
  for (const ScanLikelihood model : {ScanLikelihood::likelihood_field, ScanLikelihood::beam}) {
    for (const Eigen::Matrix3d& c :
         {Eigen::Matrix3d(Eigen::Matrix3d::Zero()), along, Eigen::Matrix3d(v * v.transpose())})
      EXPECT_TRUE(run({pose_of_drive(0), c}, model)) << c;
    for (const double far : {1e4, 1e9, 1e30}) {
      SCOPED_TRACE(far);
      EXPECT_TRUE(run({SE2d(far, -far, Angle::radians(far)), start_of_drive().covariance}, model));
      EXPECT_TRUE(run({pose_of_drive(0), far * Eigen::Matrix3d::Identity()}, model));
    }
    (void)run({SE2d(1e300, -1e300, Angle{}), 1e300 * Eigen::Matrix3d::Identity()}, model);
  }
}

TEST(AbusedLocaliser, OddScansAndOdometry) {
  using Change = std::function<void(LaserScan&, std::optional<Odometry>&)>;
  const std::vector<Change> changes = {
      [](LaserScan& s, auto&) { s.ranges_m.clear(); },
      [](LaserScan& s, auto&) { s.ranges_m.resize(1); },
      [](LaserScan& s, auto&) { s.ranges_m.assign(kBeams, NAN); },
      [](LaserScan& s, auto&) {
        s.max_range_m = INFINITY;
        s.ranges_m.assign(kBeams, 3e38F);
      },
      [](LaserScan& s, auto&) { s.ranges_m.assign(kBeams, -INFINITY); },
      [](LaserScan& s, auto&) { s.min_range_m = s.max_range_m = NAN; },
      [](LaserScan& s, auto&) { s.ranges_m.assign(40'000, 2.0F); },
      [](auto&, auto& o) { o.reset(); },
      [](auto&, auto& o) { o = Odometry(SE2d(kNan, 0.0, Angle{})); },
      [](auto&, auto& o) { o = Odometry(SE2d(kInf, 0.0, Angle::radians(kInf))); },
      [](auto&, auto& o) { o = Odometry(SE2d(1e9, 1e9, 3_rad)); },
      [](auto&, auto& o) { o = Odometry(SE2d(1e300, -1e300, 3_rad)); },
  };
  for (const ScanLikelihood model : {ScanLikelihood::likelihood_field, ScanLikelihood::beam})
    for (std::size_t i = 0; i < changes.size(); ++i)
      for (const int at : {0, 1, 4}) {
        SCOPED_TRACE("change " + std::to_string(i) + " at " + std::to_string(at));
        LocalisationOptions options = quick_options();
        options.model = model;
        Localiser localiser = localiser_at_start(options);
        for (int k = 0; k < 8; ++k) {
          LaserScan scan = scan_of_drive(k);
          std::optional<Odometry> odometry = odometry_of_drive(k);
          if (k == at) changes[i](scan, odometry);
          const auto outcome = localiser.add_scan(scan, odometry);
          ASSERT_TRUE(outcome);
          EXPECT_TRUE(outcome->T_map_base.covariance.allFinite());
        }
        EXPECT_TRUE(all_finite(numbers_of(localiser)));
      }
}

// Odometry that moves, within what jitter of the stamps allows, in a nanosecond, and then is
// missing: the velocity of the prediction stays one that the robot can have. At most 1.4 m and 0.5
// s at 3 m/s, 2.9 m in all, of which the bound is about twice; 1.4 m/ns would lead 7e8 m away.
TEST(AbusedLocaliser, StampsANanosecondApart) {
  Localiser localiser = localiser_at_start();
  const LogTime now = time_of_drive(0);
  EXPECT_TRUE(localiser.add_scan(scan_of_room(now, pose_of_drive(0)), Odometry(SE2d())));
  EXPECT_TRUE(localiser.add_motion(now + Duration(1), Odometry(SE2d(1.4, 0.0, Angle{}))));
  const auto outcome =
      localiser.add_scan(scan_of_room(now + Duration(500'000'000), pose_of_drive(0)), std::nullopt);
  ASSERT_TRUE(outcome);
  EXPECT_LT((outcome->T_map_base.mean.translation() - pose_of_drive(0).translation()).norm(), 6.0);
}

// Something covers the laser: the scan fits nowhere, and no pose better than any other.
TEST(AbusedLocaliser, CoveredLaser) {
  const LocalisationOptions options = quick_options();
  Localiser localiser = localiser_at_start(options);
  for (int k = 0; k < 100; ++k) {
    LaserScan scan = scan_of_drive(k);
    if (k >= 40) scan.ranges_m.assign(kBeams, 0.3F);
    const auto outcome = localiser.add_scan(scan, odometry_of_drive(k));
    ASSERT_TRUE(outcome);
    ASSERT_LE(outcome->particles, 2 * options.max_particles) << k;
  }
}

TEST(AbusedLocaliser, TimesAtTheLimits) {
  using Limits = std::numeric_limits<std::int64_t>;
  Localiser localiser = localiser_at_start();
  int k = 0;
  for (const std::int64_t ns :
       {Limits::min(), Limits::min() + 1, std::int64_t{0}, Limits::max() - 1, Limits::max()}) {
    const LogTime time = LogTime::from_nanoseconds(ns);
    const auto outcome =
        localiser.add_scan(scan_of_room(time, pose_of_drive(k)), odometry_of_drive(k));
    ASSERT_TRUE(outcome);
    EXPECT_TRUE(outcome->T_map_base.covariance.allFinite());
    EXPECT_TRUE(localiser.add_radar(time, points_of_drive(k), {}));
    ++k;
  }
  EXPECT_FALSE(localiser.add_scan(scan_of_room(LogTime::from_nanoseconds(Limits::max()), {}), {}));
  EXPECT_TRUE(all_finite(numbers_of(localiser)));
}

TEST(AbusedLocaliser, LivesAsAValue) {
  const auto drive = [](Localiser& localiser, int from, int to) {
    std::vector<double> all;
    for (int k = from; k < to; ++k)
      append(all, localiser.add_scan(scan_of_drive(k), odometry_of_drive(k)).value());
    return all;
  };
  const auto make = [&] {
    Localiser localiser(map_of_room(), quick_options(), 7);
    (void)drive(localiser, 0, 3);
    return localiser;
  };
  expect_move_semantics(make, [&](Localiser& localiser) { return drive(localiser, 3, 9); });
  const auto results = in_two_threads([&](int) {
    LocalisationOptions options = quick_options();
    options.threads = 2;
    Localiser localiser(map_of_room(), options, 7);
    return drive(localiser, 0, 9);
  });
  EXPECT_EQ(results[0], results[1]);
}

TEST(AbusedLocaliser, Recordings) {
  Recording recording;
  const auto run = [&](const LocalisationControl& control = {},
                       LocalisationOptions options = quick_options()) {
    return run_localisation(recording, map_of_room(), options, 1, start_of_drive(), control);
  };
  EXPECT_FALSE(run());
  for (int k = 0; k < 6; ++k) {
    recording.scans.push_back(scan_of_drive(k));
    recording.odometry.push_back({time_of_drive(k), *odometry_of_drive(k)});
    recording.radar.push_back({time_of_drive(k), {{1.0F, 0.0F, 0.0F, 0.0F, 0.0F}}});
  }
  int calls = 0;
  LocalisationControl control;
  control.progress = [&](double) { return ++calls < 2; };
  control.snapshots_at = {kNan, -1.0, 0.0, 2.0, kInf};
  const auto stopped = run(control);
  ASSERT_TRUE(stopped);
  EXPECT_EQ(calls, 2);
  LocalisationOptions none = quick_options();
  none.use_lidar = none.use_radar = false;
  EXPECT_FALSE(run({}, none));
  LocalisationOptions radar = quick_options();
  radar.use_lidar = false;
  for (const double longest : {0.0, -1.0, kNan, kInf, 1e300}) {
    radar.radar.longest_s = longest;
    for (const std::size_t frames : {std::size_t{0}, std::size_t{1}, SIZE_MAX}) {
      radar.radar.frames = frames;
      EXPECT_TRUE(run({}, radar));
    }
  }
  // A gap of centuries between two scans: its odometry is added in a bounded number of steps.
  recording.scans.push_back(scan_of_room(
      LogTime::from_nanoseconds(std::numeric_limits<std::int64_t>::max()), pose_of_drive(5)));
  recording.scans.front().time =
      LogTime::from_nanoseconds(std::numeric_limits<std::int64_t>::min());
  const auto gap = run();
  ASSERT_TRUE(gap);
  EXPECT_EQ(gap->outcomes.size(), 7U);
}

}  // namespace
}  // namespace wayfare::tests
