// Does the navigation filter know how far it is off? Simulated drives of 310 s and 4.5 km with an
// automotive unit, eight satellites, 2 m and 0.1 m/s.

#include <gtest/gtest.h>

#include <wayfare/sim/ins_monte_carlo.hpp>

namespace wayfare::sim {
namespace {

constexpr int kStates = ins_state::kSize;

// Only what the filter models: no knowledge of wheels and standstill, which are not noise.
InsMonteCarloOptions modelled() {
  InsMonteCarloOptions o;
  o.ranges.max_satellites = 8;
  o.ranges.antenna_lever_arm_m = {0.3, -0.2, -1.4};
  o.filter.zero_velocity_updates = false;
  o.filter.non_holonomic_in_outage = false;
  o.threads = 2;
  return o;
}

struct Outcome {
  eval::NeesOverRuns all, navigation;
  eval::SigmaCount<kStates> within;
};

Outcome judge(const InsMonteCarloOptions& options, std::size_t runs, std::uint64_t seed) {
  const auto courses = ins_monte_carlo(demo_drive(), gps_and_galileo(), runs, options, Rng(seed));
  Outcome o{{kStates, courses[0].size()}, {9, courses[0].size()}, {}};
  for (const InsErrorCourse& course : courses) {
    EXPECT_EQ(course.size(), courses[0].size());
    for (std::size_t k = 0; k < course.size(); ++k) {
      o.all.add(k, course[k].nees);
      o.navigation.add(k, course[k].navigation_nees);
      o.within.add(course[k].error, course[k].sigma);
    }
  }
  return o;
}

TEST(GnssInsConsistency, ErrorsOfAHundredDrivesAreWhatTheFilterSays) {
  const Outcome o = judge(modelled(), 100, 7);
  EXPECT_EQ(o.all.epochs(), 310U);
  // Honest: 0.95 of the epochs. Errors last for many epochs, so the share scatters; the mean over
  // all has the spread of about 100 independent runs of some ten correlation times each.
  EXPECT_GT(o.all.share_within(0.95), 0.88);
  EXPECT_GT(o.navigation.share_within(0.95), 0.88);
  EXPECT_NEAR(o.all.mean_of_all(), kStates, 0.03 * kStates);
  EXPECT_NEAR(o.navigation.mean_of_all(), 9.0, 0.05 * 9.0);
  EXPECT_NEAR(o.within.share(1).mean(), 0.6827, 0.02);
  EXPECT_NEAR(o.within.share(2).mean(), 0.9545, 0.01);
  EXPECT_NEAR(o.within.share(3).mean(), 0.9973, 0.003);
  // Scale factors hardly change in a run: of these a hundred values only are independent.
  EXPECT_GT(o.within.share(3).minCoeff(), 0.98);
}

TEST(GnssInsConsistency, TheTestSeesAFilterThatIsTooProud) {
  InsMonteCarloOptions proud = modelled();
  proud.filter.range_sigma_scale = 0.8;
  const Outcome o = judge(proud, 12, 7);
  EXPECT_LT(o.all.share_within(0.95), 0.5);
}

TEST(GnssInsConsistency, HoldsWithConstraintsThroughOutagesAndAMountedUnit) {
  InsMonteCarloOptions o;
  o.ranges.max_satellites = 8;
  o.imu.q_body_imu = SO3d::exp({0.4, -0.3, 2.0});
  o.ranges.outages = {{LogTime::from_seconds(60), LogTime::from_seconds(75), 0},
                      {LogTime::from_seconds(150), LogTime::from_seconds(170), 2}};
  o.threads = 2;
  const Outcome outcome = judge(o, 20, 3);
  // Constraints hold better than they claim, so errors may be smaller than said, never larger.
  EXPECT_GT(outcome.within.share(3).minCoeff(), 0.97);
  EXPECT_GT(outcome.within.share(3).mean(), 0.995);
  EXPECT_LT(outcome.all.mean_of_all(), 1.1 * kStates);
}

TEST(GnssInsConsistency, IsTheSameForAnyNumberOfThreads) {
  InsMonteCarloOptions one = modelled(), three = modelled();
  one.threads = 1, three.threads = 3;
  const auto a = ins_monte_carlo(demo_drive(), gps_and_galileo(), 3, one, Rng(1));
  const auto b = ins_monte_carlo(demo_drive(), gps_and_galileo(), 3, three, Rng(1));
  for (std::size_t r = 0; r < 3; ++r)
    for (std::size_t k = 0; k < a[r].size(); ++k) EXPECT_EQ(a[r][k].error, b[r][k].error);
}

// Round and round for a day, gently enough for ten readings a second.
VehicleTrajectory all_day() {
  VehicleLimits gentle;
  gentle.acceleration_mps2 = gentle.braking_mps2 = gentle.lateral_acceleration_mps2 = 0.8;
  gentle.turn_radius_m = 80.0, gentle.build_up_s = 4.0;
  std::vector<Waypoint> route;
  for (int lap = 0; lap < 320; ++lap) {
    route.push_back({0, 0, 0, 0});
    route.push_back({900, 0, 10, lap % 7 == 0 ? 60.0 : 0.0});
    route.push_back({900, 800, 0, 0});
    route.push_back({0, 800, 5, lap % 3 == 0 ? 20.0 : 0.0});
  }
  const Geodetic origin{Angle::degrees(51.0), Angle::degrees(-114.0), 1100.0};
  return drive_waypoints(origin, route, gentle).value();
}

TEST(GnssInsConsistency, TheCovarianceStaysPositiveDefiniteForADay) {
  const VehicleTrajectory drive = all_day();
  ASSERT_GT(to_seconds(drive.end() - drive.begin()), 24.0 * 3600.0);
  InsMonteCarloOptions o = modelled();
  o.imu.period = from_seconds(0.1);
  const InsErrorCourse course = ins_error_course(drive, gps_and_galileo(), o, Rng(1));
  ASSERT_GT(course.size(), 86400U);
  // Whether errors are as large as said is asked of the drives above, at a hundred readings a
  // second.
  for (const InsErrorAt& at : course) {
    ASSERT_TRUE(std::isfinite(at.nees)) << at.time.seconds();  // NaN where P is not definite
    ASSERT_LT(at.error.head<3>().norm(), 30.0) << at.time.seconds();
  }
}

}  // namespace
}  // namespace wayfare::sim
