// Consistency of the navigation filter on simulated drives of 310 s and 4.5 km with an automotive
// unit, eight satellites, 2 m and 0.1 m/s.

#include <cmath>

#include <gtest/gtest.h>

#include <wayfare/eval/consistency.hpp>
#include <wayfare/sim/ins_monte_carlo.hpp>

namespace wayfare::sim {
namespace {

constexpr int kStates = ins_state::kSize;

// Without constraints, whose errors are not white noise.
InsMonteCarloOptions modelled() {
  InsMonteCarloOptions o;
  o.ranges.max_satellites = 8;
  o.ranges.antenna_lever_arm_m = {0.3, -0.2, -1.4};
  o.filter.zero_velocity_updates = false;
  o.filter.non_holonomic_in_outage = false;
  o.threads = 2;
  return o;
}

constexpr auto kRange = static_cast<std::size_t>(InnovationRecord::Kind::range);
constexpr auto kRate = static_cast<std::size_t>(InnovationRecord::Kind::range_rate);

struct Outcome {
  eval::NeesOverRuns all, navigation, ranges, rates;
  eval::IndependentMean run_means;  ///< NEES of 23 states
  eval::SigmaCount<kStates> within;
};

Outcome judge(const InsMonteCarloOptions& options, std::size_t runs, std::uint64_t seed) {
  const auto courses = ins_monte_carlo(demo_drive(), gps_and_galileo(), runs, options, Rng(seed));
  const std::size_t epochs = courses[0].size();
  Outcome o{{kStates, epochs}, {9, epochs}, {1, epochs}, {1, epochs}, {}, {}};
  for (const InsErrorSeries& course : courses) {
    EXPECT_EQ(course.size(), epochs);
    double sum = 0.0;
    for (std::size_t k = 0; k < course.size(); ++k) {
      o.all.add(k, course[k].nees);
      o.navigation.add(k, course[k].navigation_nees);
      o.ranges.add(k, course[k].nis[kRange].sum, course[k].nis[kRange].count);
      o.rates.add(k, course[k].nis[kRate].sum, course[k].nis[kRate].count);
      o.within.add(course[k].error, course[k].sigma);
      sum += course[k].nees;
    }
    o.run_means.add(sum / static_cast<double>(epochs));
  }
  return o;
}

TEST(GnssInsConsistency, ErrorsOfAHundredDrivesMatchTheCovariance) {
  const Outcome o = judge(modelled(), 100, 7);
  EXPECT_EQ(o.all.epochs(), 310U);
  // Runs are independent: three standard errors of their mean.
  EXPECT_NEAR(o.run_means.mean(), kStates, 3.0 * o.run_means.standard_error());
  EXPECT_LT(o.run_means.standard_error(), 0.03 * kStates);
  // Expected: 0.95 of the epochs. Errors are correlated over epochs: over ten such groups of a
  // hundred runs (seeds 1000 to 1009) the share has a standard deviation of 0.05.
  EXPECT_GT(o.all.share_within(0.95), 0.85);
  EXPECT_GT(o.navigation.share_within(0.95), 0.85);
  EXPECT_NEAR(o.navigation.mean_of_all(), 9.0, 0.05 * 9.0);
  EXPECT_NEAR(o.within.share(1).mean(), 0.6827, 0.02);
  EXPECT_NEAR(o.within.share(2).mean(), 0.9545, 0.01);
  EXPECT_NEAR(o.within.share(3).mean(), 0.9973, 0.003);
  // Scale factors hardly change within a run: only a hundred values are independent.
  EXPECT_GT(o.within.share(3).minCoeff(), 0.98);
}

// The innovations of a consistent filter are independent: all of a kind form one sample.
TEST(GnssInsConsistency, InnovationsOfAHundredDrivesAreConsistent) {
  const Outcome o = judge(modelled(), 100, 8);
  for (const eval::NeesOverRuns* nis : {&o.ranges, &o.rates}) {
    EXPECT_EQ(nis->count(), 100U * 310U * 8U);
    EXPECT_TRUE(eval::mean_nees_bounds(1, nis->count(), 0.99).contains(nis->mean_of_all()))
        << nis->mean_of_all();
    // Three standard deviations of the binomial of 310 epochs.
    EXPECT_NEAR(nis->share_within(0.95), 0.95, 3.0 * std::sqrt(0.95 * 0.05 / 310.0));
  }
}

TEST(GnssInsConsistency, InnovationsRevealOptimisticMeasurementSigmas) {
  InsMonteCarloOptions o = modelled();
  o.filter.range_sigma_scale = 0.5;  // assumed σ is half the true one
  const Outcome proud = judge(o, 5, 8);
  EXPECT_GT(proud.ranges.mean_of_all(), 2.0);
  EXPECT_GT(proud.rates.mean_of_all(), 2.0);
  EXPECT_LT(proud.rates.share_within(0.95), 0.1);
}

TEST(GnssInsConsistency, TheTestDetectsAnOverconfidentFilter) {
  InsMonteCarloOptions proud = modelled();
  proud.filter.range_sigma_scale = 0.8;
  const Outcome o = judge(proud, 12, 7);
  EXPECT_LT(o.all.share_within(0.95), 0.5);
}

TEST(GnssInsConsistency, ConsistentWithConstraintsOutagesAndMounting) {
  InsMonteCarloOptions o;
  o.ranges.max_satellites = 8;
  o.imu.q_body_imu = SO3d::exp({0.4, -0.3, 2.0});
  o.ranges.outages = {{LogTime::from_seconds(60), LogTime::from_seconds(75), 0},
                      {LogTime::from_seconds(150), LogTime::from_seconds(170), 2}};
  o.threads = 2;
  const Outcome outcome = judge(o, 20, 3);
  // Constraints are more accurate than assumed: errors may be smaller, never larger.
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

// Four days with independent errors. The mean of a day's NEES has a variance of at most Σ 2 τ/T
// over the 23 errors with correlation times τ of at most 20 000 s for six scale factors and 3000 s
// for the rest, T a day: 3.96 in total. Navigation errors, with τ of about a minute, have 2 · 9 ·
// 60 s/T = 0.11².
TEST(GnssInsConsistency, StaysConsistentAndPositiveDefiniteForDays) {
  constexpr int kDays = WAYFARE_TEST_SCANS > 0 ? 1 : 4;
  const VehicleTrajectory drive = round_drive(320);
  ASSERT_GT(to_seconds(drive.end() - drive.begin()), 24.0 * 3600.0);
  InsMonteCarloOptions o = modelled();
  o.imu.period = from_seconds(0.1);
  const auto courses = ins_monte_carlo(drive, gps_and_galileo(), kDays, o, Rng(1));
  eval::IndependentMean all, navigation;
  for (const InsErrorSeries& course : courses) {
    ASSERT_GT(course.size(), 86400U);
    double sum = 0.0, navigation_sum = 0.0;
    for (const InsErrorAt& at : course) {
      ASSERT_TRUE(std::isfinite(at.nees)) << at.time.seconds();  // NaN where P is not definite
      ASSERT_LT(at.error.head<3>().norm(), 30.0) << at.time.seconds();
      sum += at.nees, navigation_sum += at.navigation_nees;
    }
    all.add(sum / static_cast<double>(course.size()));
    navigation.add(navigation_sum / static_cast<double>(course.size()));
  }
  constexpr double kSigmas = 2.58;  // 99 %
  EXPECT_NEAR(all.mean(), kStates, kSigmas * std::sqrt(3.96 / kDays));
  EXPECT_NEAR(navigation.mean(), 9.0, kSigmas * 0.11 / std::sqrt(kDays));
}

}  // namespace
}  // namespace wayfare::sim
