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

}  // namespace
}  // namespace wayfare::sim
