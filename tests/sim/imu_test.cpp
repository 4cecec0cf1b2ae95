#include <wayfare/sim/vehicle_trajectory.hpp>

#include <cmath>

#include <gtest/gtest.h>

namespace wayfare::sim {
namespace {

// At rest and level at 47° north.
VehicleTrajectory parked(double seconds) {
  std::vector<NavState> states(5);
  for (std::size_t i = 0; i < states.size(); ++i) {
    states[i].time = LogTime::from_seconds(seconds * static_cast<double>(i) / 4.0);
    states[i].position = {Angle::degrees(47.0), Angle::degrees(8.5), 450.0};
  }
  TrackFit coarse;
  coarse.knot_spacing_s = seconds / 8.0;
  return follow_solution(states, coarse).value();
}

TEST(SimulateImu, APerfectUnitAtRestMeasuresGravityAndEarthRate) {
  ImuParams params;
  params.noise = perfect_imu();
  Rng rng(1);
  const SimulatedImu imu = simulate_imu(parked(10.0), params, rng);
  ASSERT_EQ(imu.samples.size(), 1001U);
  EXPECT_EQ(imu.samples.front().time, LogTime{});
  const double latitude = Angle::degrees(47.0).radians();
  const double g = normal_gravity_mps2(std::sin(latitude), 450.0);
  for (const ImuSample& s : imu.samples) {
    EXPECT_LT((s.specific_force_mps2 - Eigen::Vector3d(0, 0, -g)).norm(), 1e-9);
    const Eigen::Vector3d earth =
        wgs84::kEarthRate_radps * Eigen::Vector3d(std::cos(latitude), 0, -std::sin(latitude));
    EXPECT_LT((s.angular_rate_radps - earth).norm(), 1e-12);
  }
}

TEST(SimulateImu, MeasuresInItsOwnAxes) {
  ImuParams params;
  params.noise = perfect_imu();
  params.q_body_imu = SO3d::exp({0.3, -0.2, 2.0});
  Rng rng(1);
  const VehicleTrajectory drive = demo_drive();
  const SimulatedImu imu = simulate_imu(drive, params, rng);
  const VehicleMotion m = drive.motion(imu.samples[3000].time);
  EXPECT_LT(
      (params.q_body_imu * imu.samples[3000].specific_force_mps2 - m.specific_force_mps2).norm(),
      1e-12);
  EXPECT_LT(
      (params.q_body_imu * imu.samples[3000].angular_rate_radps - m.angular_rate_radps).norm(),
      1e-12);
}

TEST(SimulateImu, MeansOverAPeriodAverageToThoseOverALongerOne) {
  // The same interval sampled at 5 Hz and at 200 Hz: the fast means average to the slow ones.
  const VehicleTrajectory drive = demo_drive();
  ImuParams slow, fast;
  slow.noise = fast.noise = perfect_imu();
  slow.mean_of_period = fast.mean_of_period = true;
  slow.period = from_seconds(0.05), fast.period = from_seconds(0.005);
  Rng a(1), b(1);
  const auto s = simulate_imu(drive, slow, a), f = simulate_imu(drive, fast, b);
  for (std::size_t i = 1; i < s.samples.size(); i += 7) {
    Eigen::Vector3d rate = Eigen::Vector3d::Zero();
    for (std::size_t k = 0; k < 10; ++k) rate += f.samples[10 * i - k].angular_rate_radps / 10.0;
    EXPECT_LT((rate - s.samples[i].angular_rate_radps).norm(), 1e-6);
  }
}

TEST(SimulateImu, TheSameSeedGivesTheSameSamples) {
  const VehicleTrajectory drive = parked(5.0);
  Rng a(7), b(7), c(8);
  const auto x = simulate_imu(drive, {}, a), y = simulate_imu(drive, {}, b);
  const auto z = simulate_imu(drive, {}, c);
  for (std::size_t i = 0; i < x.samples.size(); ++i) {
    EXPECT_EQ(x.samples[i].specific_force_mps2, y.samples[i].specific_force_mps2);
    EXPECT_EQ(x.samples[i].angular_rate_radps, y.samples[i].angular_rate_radps);
  }
  EXPECT_NE(x.samples[9].specific_force_mps2, z.samples[9].specific_force_mps2);
}

// Allan variance of rates sampled every dt, clusters of m (IEEE 952-1997, annex C), not
// overlapping: n/m nearly independent clusters, relative spread √(3/(2(n/m − 1))) for white noise.
double allan_variance(const std::vector<double>& x, std::size_t m) {
  std::vector<double> means;
  for (std::size_t i = 0; i + m <= x.size(); i += m) {
    double sum = 0;
    for (std::size_t k = 0; k < m; ++k) sum += x[i + k];
    means.push_back(sum / static_cast<double>(m));
  }
  double sum = 0;
  for (std::size_t i = 1; i < means.size(); ++i) sum += std::pow(means[i] - means[i - 1], 2);
  return sum / (2.0 * static_cast<double>(means.size() - 1));
}

TEST(SimulateImu, WhiteNoiseFallsWithTheRootOfAveragingTime) {
  ImuParams params;
  params.noise = perfect_imu();
  params.noise.gyro_white_rad_per_sqrt_s = {1e-4, 2e-4, 3e-4};
  params.noise.accel_white_mps_per_sqrt_s = {1e-3, 2e-3, 3e-3};
  Rng rng(3);
  const SimulatedImu imu = simulate_imu(parked(600.0), params, rng);
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double> rate, force;
    for (const ImuSample& s : imu.samples) {
      rate.push_back(s.angular_rate_radps[axis]);
      force.push_back(s.specific_force_mps2[axis]);
    }
    for (const std::size_t m : {1UL, 10UL, 100UL}) {
      // σ²(T) = N²/T; five standard deviations of the estimate, here with n/m clusters.
      const double average_s = 0.01 * static_cast<double>(m);
      const std::size_t clusters = rate.size() / m;
      const double bound = 5.0 * std::sqrt(1.5 / static_cast<double>(clusters));
      const double gyro = std::pow(params.noise.gyro_white_rad_per_sqrt_s[axis], 2) / average_s;
      const double accel = std::pow(params.noise.accel_white_mps_per_sqrt_s[axis], 2) / average_s;
      EXPECT_NEAR(allan_variance(rate, m) / gyro, 1.0, bound) << m;
      EXPECT_NEAR(allan_variance(force, m) / accel, 1.0, bound) << m;
    }
  }
}

TEST(ImuErrorProcess, IsStationaryWithItsCorrelationTime) {
  // Over many units: variance σ² at the start and after any time; correlation e^(−T/τ) between.
  // Steps of any length give the same distribution, since the discretisation is exact.
  ImuNoise noise;
  noise.gyro_bias_radps = {{0.1, 0.2, 0.3}, {50.0, 100.0, 200.0}};
  noise.accel_scale = {{0.01, 0.02, 0.03}, {10.0, 20.0, 40.0}};
  const int units = 4000;
  Eigen::Vector3d before = Eigen::Vector3d::Zero(), after = before, product = before;
  Eigen::Vector3d scale_product = before;
  for (int unit = 0; unit < units; ++unit) {
    Rng rng = Rng(11).stream(static_cast<std::uint64_t>(unit));
    ImuErrorProcess process(noise, rng);
    const ImuErrors first = process.errors();
    for (const double step : {1.0, 40.0, 9.0}) process.step(step, rng);
    const ImuErrors& last = process.errors();
    before += first.gyro_bias_radps.cwiseAbs2() / units;
    after += last.gyro_bias_radps.cwiseAbs2() / units;
    product += first.gyro_bias_radps.cwiseProduct(last.gyro_bias_radps) / units;
    scale_product += first.accel_scale.cwiseProduct(last.accel_scale) / units;
  }
  const Eigen::Vector3d variance = noise.gyro_bias_radps.sigma.cwiseAbs2();
  const Eigen::Vector3d scale_variance = noise.accel_scale.sigma.cwiseAbs2();
  for (int i = 0; i < 3; ++i) {
    const double five = 5.0 * std::sqrt(2.0 / units);
    EXPECT_NEAR(before[i] / variance[i], 1.0, five);
    EXPECT_NEAR(after[i] / variance[i], 1.0, five);
    EXPECT_NEAR(product[i] / variance[i], std::exp(-50.0 / noise.gyro_bias_radps.tau_s[i]), five);
    EXPECT_NEAR(scale_product[i] / scale_variance[i], std::exp(-50.0 / noise.accel_scale.tau_s[i]),
                five);
  }
}

}  // namespace
}  // namespace wayfare::sim
