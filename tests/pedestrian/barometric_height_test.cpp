// Heights by air pressure, alone and fused with a foot's, on simulated stairs.
#include <wayfare/pedestrian/barometric_height.hpp>

#include <cmath>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include <wayfare/core/atmosphere.hpp>
#include <wayfare/core/random.hpp>
#include <wayfare/core/statistics.hpp>
#include <wayfare/pedestrian/foot_tracker.hpp>
#include <wayfare/sim/vehicle_trajectory.hpp>
#include <wayfare/sim/walks.hpp>

namespace wayfare {
namespace {

LogTime at(double t_s) { return LogTime::from_seconds(t_s); }

// The tables of ISO 2533: 1013.25 hPa at sea level, 954.61 hPa at 500 m, 898.74 hPa at 1000 m.
TEST(Atmosphere, IsTheStandardOne) {
  EXPECT_NEAR(barometric_height_m(95461.0, 101325.0), 500.0, 0.1);
  EXPECT_NEAR(barometric_height_m(89874.0, 101325.0), 1000.0, 0.2);
  EXPECT_EQ(barometric_height_m(101325.0, 101325.0), 0.0);
  // 8.324 m per hPa at sea level: R·T/(g·p) = 287.05·288.15/(9.80665·101325) = 0.08324 m/Pa.
  EXPECT_NEAR(barometric_height_m(101225.0, 101325.0), 8.324, 0.005);
  for (const double h : {-50.0, 3.4, 2000.0})
    EXPECT_NEAR(barometric_height_m(barometric_pressure_Pa(h, 98000.0), 98000.0), h, 1e-9);
}

TEST(BarometricHeight, WithoutReadingsIsTheSumOfTheRises) {
  BarometricHeight height;
  height.move(at(1.0), 0.17, 0.01);
  height.move(at(2.0), 0.17, 0.03);
  EXPECT_DOUBLE_EQ(height.height_m(), 0.34);
  EXPECT_DOUBLE_EQ(height.sigma_m(), 0.2);
  EXPECT_FALSE(height.by_pressure_m());
}

TEST(BarometricHeight, RefusesWhatIsNoPressure) {
  BarometricHeight height;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const double p : {nan, 0.0, -1.0, 1013.25, 1e9, std::numeric_limits<double>::infinity()})
    EXPECT_EQ(height.add(at(1.0), p), UpdateStatus::missing) << p;
  EXPECT_EQ(height.height_m(), 0.0);
  EXPECT_EQ(height.add(at(1.0), 101325.0), UpdateStatus::used);
  EXPECT_EQ(height.add(at(0.5), 101000.0), UpdateStatus::late);
  EXPECT_EQ(height.report().missing, 6U);
  EXPECT_EQ(height.report().late, 1U);
  EXPECT_NEAR(height.height_m(), 0.0, 1e-12);
}

// Rises that follow the truth with random errors, and pressure with the noise of the parameters:
// the errors have the standard deviations that the filter states, and are smaller than those of
// either source.
TEST(BarometricHeight, IsConsistentAndBetterThanEither) {
  constexpr double kRise_m = 0.17, kSigma_m = 0.05, kStep_s = 0.5;
  constexpr int kSteps = 400, kRuns = 200;
  double normalised = 0.0, nis = 0.0;
  std::vector<double> both, pressure, reckoned;
  for (int run = 0; run < kRuns; ++run) {
    Rng rng(static_cast<std::uint64_t>(run) + 1);
    std::vector<double> truth;
    for (int i = 0; i < kSteps; ++i) truth.push_back(kRise_m * i);
    const auto pressures = sim::simulate_pressure(truth, kStep_s, {}, rng);
    BarometricHeight height;
    double sum = 0.0;
    for (int i = 0; i < kSteps; ++i) {
      const double rise = i == 0 ? 0.0 : kRise_m + kSigma_m * rng.normal();
      sum += rise;
      height.move(at(kStep_s * i), rise, i == 0 ? 0.0 : kSigma_m * kSigma_m);
      ASSERT_EQ(height.add(at(kStep_s * i), pressures[static_cast<std::size_t>(i)]),
                UpdateStatus::used);
      nis += i == 0 ? 0.0 : height.nis() / (kSteps - 1.0) / kRuns;
    }
    const double error = height.height_m() - truth.back();
    normalised += std::pow(error / height.sigma_m(), 2) / kRuns;
    both.push_back(error);
    pressure.push_back(*height.by_pressure_m() - truth.back());
    reckoned.push_back(sum - truth.back());
  }
  // χ² of 200: standard deviation 0.1; of 79800 innovations: 0.005.
  EXPECT_NEAR(normalised, 1.0, 0.35);
  EXPECT_NEAR(nis, 1.0, 0.02);
  EXPECT_LT(summarise(both).rmse, 0.9 * summarise(pressure).rmse);
  EXPECT_LT(summarise(both).rmse, 0.9 * summarise(reckoned).rmse);
}

// A flight of 3.4 m: the foot's track follows it, and the path without flights is level.
TEST(SimulatedFeet, ClimbStairs) {
  sim::FeetPlan plan;
  plan.strides = 40;
  const auto level = sim::simulate_feet(plan, sim::perfect_imu(), Rng(1));
  EXPECT_DOUBLE_EQ(level.left.position.back().z(), 0.0);
  EXPECT_DOUBLE_EQ(level.length_m, 39.5 * plan.stride_m);
  plan.stairs = {{10, 10}, {30, 5, -0.34}};
  const auto truth = sim::simulate_feet(plan, sim::perfect_imu(), Rng(1));
  EXPECT_NEAR(truth.left.position.back().z(), 3.4 - 1.7, 1e-9);
  EXPECT_NEAR(truth.right.position.back().z(), 3.4 - 1.7, 1e-9);
  EXPECT_NEAR(truth.length_m, (39.5 - 15) * plan.stride_m + 15 * 0.58, 1e-9);
  EXPECT_NEAR(truth.left.position.back().x(), truth.length_m, 1e-9);
  FootTracker tracker;
  for (const ImuSample& s : truth.left.samples) tracker.add(s);
  tracker.finish([](const FootPose&) {});
  EXPECT_NEAR(tracker.pose().position_m.z(), 1.7, 0.1);
}

}  // namespace
}  // namespace wayfare
