#include <wayfare/sim/floor_plan.hpp>

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

namespace wayfare::sim {
namespace {

FloorPlan square() {
  const double s = 10.0;
  return FloorPlan::from_segments(
             {{{0, 0}, {s, 0}}, {{s, 0}, {s, s}}, {{s, s}, {0, s}}, {{0, s}, {0, 0}}})
      .value();
}

Lidar2dParams exact() {
  Lidar2dParams params;
  params.range_noise_m = params.resolution_m = params.missed_return = 0.0;
  return params;
}

SE2d centre(LogTime) { return {5.0, 5.0, Angle::radians(0.5 * std::numbers::pi)}; }

TEST(SimulateScan, WithoutNoiseGivesTheDistancesInASquare) {
  Rng rng(1);
  const LaserScan scan = simulate_scan(square(), centre, LogTime{}, exact(), rng);
  ASSERT_EQ(scan.ranges_m.size(), 180U);
  // From the centre a wall is 5 m / cos of the angle to the nearest of the four normals.
  for (std::size_t i = 0; i < 180; ++i) {
    const double to_normal = std::remainder(scan.bearing(i).radians(), 0.5 * std::numbers::pi);
    EXPECT_NEAR(scan.ranges_m[i], 5.0 / std::cos(to_normal), 1e-6);
  }
}

TEST(SimulateScan, EndPointsLieOnTheWallsWhateverThePose) {
  Rng rng(3);
  for (int k = 0; k < 50; ++k) {
    const SE2d pose(rng.uniform(1, 9), rng.uniform(1, 9), Angle::radians(rng.uniform(-3, 3)));
    const auto T_plan_laser = [&](LogTime) { return pose; };
    const LaserScan scan = simulate_scan(square(), T_plan_laser, LogTime{}, exact(), rng);
    for (std::size_t i = 0; i < scan.ranges_m.size(); ++i) {
      const double b = scan.bearing(i).radians(), r = static_cast<double>(scan.ranges_m[i]);
      const Eigen::Vector2d p = pose * Eigen::Vector2d(r * std::cos(b), r * std::sin(b));
      EXPECT_NEAR((p - Eigen::Vector2d(5, 5)).cwiseAbs().maxCoeff(), 5.0, 2e-6);
    }
  }
}

TEST(SimulateScan, NoiseHasTheStatedMeanSpreadAndLosses) {
  Lidar2dParams clean_params = full_circle(360);
  clean_params.range_noise_m = clean_params.resolution_m = clean_params.missed_return = 0.0;
  const double sigma = 0.03, lost = 0.1;
  Lidar2dParams params = clean_params;
  params.range_noise_m = sigma;
  params.missed_return = lost;
  Rng rng(7);
  const LaserScan clean = simulate_scan(square(), centre, LogTime{}, clean_params, rng);
  double sum = 0, squares = 0, returned = 0;
  const double beams = 360.0 * 300;
  for (int k = 0; k < 300; ++k) {
    const LaserScan scan = simulate_scan(square(), centre, LogTime{}, params, rng);
    for (std::size_t i = 0; i < 360; ++i) {
      if (!scan.returned(i)) continue;
      const double e = static_cast<double>(scan.ranges_m[i] - clean.ranges_m[i]);
      sum += e, squares += e * e, returned += 1;
    }
  }
  // Five standard deviations of each estimate: σ/√n, σ²√(2/n), √(p(1-p)/n).
  EXPECT_NEAR(sum / returned, 0.0, 5 * sigma / std::sqrt(returned));
  EXPECT_NEAR(squares / returned, sigma * sigma, 5 * sigma * sigma * std::sqrt(2 / returned));
  EXPECT_NEAR(1 - returned / beams, lost, 5 * std::sqrt(lost * (1 - lost) / beams));
}

TEST(SimulateScan, BeamsWithoutReturnReadTheMaximum) {
  Lidar2dParams params = exact();
  params.max_range_m = 6.0;  // the corners are √50 m away
  Rng rng(1);
  const LaserScan scan = simulate_scan(square(), centre, LogTime{}, params, rng);
  EXPECT_FALSE(scan.returned(45));
  EXPECT_EQ(scan.ranges_m[45], 6.0F);
  EXPECT_TRUE(scan.returned(90));
}

TEST(SimulateScan, RangesAreMultiplesOfTheResolution) {
  Lidar2dParams params;
  params.resolution_m = 0.01;
  Rng rng(1);
  const LaserScan scan = simulate_scan(square(), centre, LogTime{}, params, rng);
  for (const float r : scan.ranges_m) {
    const double steps = static_cast<double>(r) * 100;
    EXPECT_NEAR(steps, std::round(steps), 1e-3);
  }
}

TEST(SimulateScan, BeamsOfASweepAreMeasuredInSequence) {
  // The laser moves along x at 1 m/s and all of its beams point ahead, so that each measures the
  // distance to x = 10 from the laser's position at its time.
  Lidar2dParams params = exact();
  params.beams = 11;
  params.first_bearing = params.bearing_step = Angle{};
  params.sweep = from_seconds(1.0);
  const auto moving = [](LogTime t) { return SE2d(2.0 + t.seconds(), 5.0, Angle{}); };
  Rng rng(1);
  const LaserScan scan = simulate_scan(square(), moving, LogTime{}, params, rng);
  for (std::size_t i = 0; i < 11; ++i) {
    EXPECT_NEAR(scan.ranges_m[i], 8.0 - 0.1 * static_cast<double>(i), 1e-6);
    EXPECT_NEAR(scan.beam_time(i).seconds(), 0.1 * static_cast<double>(i), 1e-9);
  }
}

}  // namespace
}  // namespace wayfare::sim
