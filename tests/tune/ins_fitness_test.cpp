#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include <gtest/gtest.h>

#include <wayfare/core/se3.hpp>
#include <wayfare/eval/nav_error.hpp>
#include <wayfare/sim/gnss.hpp>
#include <wayfare/sim/vehicle_trajectory.hpp>
#include <wayfare/tune/ins_fitness.hpp>

namespace wayfare {
namespace {

/// The first seconds in motion of the built-in drive.
struct Simulated {
  sim::VehicleTrajectory trajectory = sim::demo_drive();
  TuningDrive drive;

  explicit Simulated(double seconds) {
    const LogTime begin = trajectory.begin() + std::chrono::seconds(20);
    const LogTime end = begin + from_seconds(seconds);
    sim::ImuParams unit;
    for (const ImuSample& s : sim::simulate_imu(trajectory, unit, Rng(1)).samples)
      if (s.time >= begin && s.time <= end) drive.imu.push_back(s);
    sim::RangeParams ranges;
    ranges.max_satellites = 8;
    for (const RangeEpoch& e :
         sim::simulate_ranges(trajectory, sim::walker_constellation(), ranges, Rng(2)).epochs)
      if (e.time >= begin && e.time <= end) drive.ranges.push_back(e);
    drive.truth = [this](LogTime t) { return std::optional(trajectory.state(t)); };
    drive.start.nav = trajectory.state(begin);
    drive.options.non_holonomic_in_outage = false;
    drive.options.zero_velocity_updates = false;
  }
};

/// Individuals around the default parameters, the last one far off.
std::vector<double> crowd(std::size_t n) {
  const auto bounds = ins_gene_bounds(GnssInsOptions{});
  Rng rng(7);
  std::vector<double> all = ins_genes(GnssInsOptions{});
  for (std::size_t i = 1; i < n; ++i)
    for (const Gene& g : bounds) all.push_back(g.value(rng.uniform()));
  for (std::size_t g = 0; g < kInsGenes; ++g) all[(n - 1) * kInsGenes + g] = 1e200;
  return all;
}

TEST(InsGenes, RoundTrip) {
  std::vector<double> genes;
  for (std::size_t i = 0; i < kInsGenes; ++i) genes.push_back(1.0 + static_cast<double>(i));
  const GnssInsOptions o = with_ins_genes(GnssInsOptions{}, genes);
  EXPECT_EQ(ins_genes(o), genes);
  // Zhang 2020, table 2: the first three are the gyros' bias σ, 25 to 27 their white noise.
  EXPECT_EQ(o.imu.gyro_bias_radps.sigma, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(o.imu.gyro_scale.tau_s, Eigen::Vector3d(10, 11, 12));
  EXPECT_EQ(o.imu.accel_bias_mps2.sigma, Eigen::Vector3d(13, 14, 15));
  EXPECT_EQ(o.imu.gyro_white_rad_per_sqrt_s, Eigen::Vector3d(25, 26, 27));
  EXPECT_EQ(o.range_sigma_scale, 33.0);
  const auto bounds = ins_gene_bounds(o);
  ASSERT_EQ(bounds.size(), kInsGenes);
  EXPECT_EQ(bounds[0].name, "gyro_bias_sigma_x");
  EXPECT_EQ(bounds[32].name, "range_sigma_scale");
  for (std::size_t i = 0; i < kInsGenes; ++i) EXPECT_NEAR(bounds[i].unit(genes[i]), 0.5, 1e-12);
}

TEST(InsFitness, IsBitIdenticalForAnyKernelNeighboursAndThreads) {
  const Simulated s(8.0);
  const auto who = crowd(11);
  InsFitnessOptions o;
  o.kernel = "baseline";
  const auto baseline = InsFitness::make(s.drive, o);
  ASSERT_TRUE(baseline.has_value());
  std::vector<double> expected(11);
  (*baseline)(who, expected);
  EXPECT_TRUE(std::isfinite(expected[0]));
  for (const char* name : {"avx2", "avx512", "baseline"}) {
    for (const int threads : {1, 3}) {
      o.kernel = name;
      o.threads = threads;
      const auto other = InsFitness::make(s.drive, o);
      if (!other) continue;  // not supported by this processor
      std::vector<double> scores(11);
      (*other)(who, scores);
      EXPECT_EQ(scores, expected) << name << ' ' << threads;
      std::vector<double> alone(1);
      (*other)(std::span(who).subspan(3 * kInsGenes, kInsGenes), alone);
      EXPECT_EQ(alone[0], expected[3]) << name;
    }
  }
}

TEST(InsFitness, MatchesTheNavigationSystem) {
  const Simulated s(20.0);
  const auto fitness = InsFitness::make(s.drive);
  ASSERT_TRUE(fitness.has_value());
  const auto mine = fitness->rmse(ins_genes(s.drive.options));
  GnssInsRecording recording{s.drive.imu, s.drive.ranges, {}, s.drive.start};
  const auto run = run_gnss_ins(recording, s.drive.options);
  ASSERT_TRUE(run.has_value());
  Eigen::Vector3d squares = Eigen::Vector3d::Zero();
  double yaw = 0.0, n = 0.0;
  for (const GnssInsPoint& p : run->points) {
    const auto e = eval::nav_error(p.nav, s.trajectory.state(p.nav.time));
    squares += e.position_ned_m.cwiseAbs2();
    yaw += e.attitude_body_rad[2] * e.attitude_body_rad[2];
    n += 1.0;
  }
  // Not bit-identical: the system initialises its clock differently and scores every reading.
  const Eigen::Vector3d rmse = (squares / n).cwiseSqrt();
  EXPECT_NEAR(mine[0].north_m, rmse[0], 0.15 * rmse[0] + 0.03);
  EXPECT_NEAR(mine[0].east_m, rmse[1], 0.15 * rmse[1] + 0.03);
  EXPECT_NEAR(mine[0].down_m, rmse[2], 0.15 * rmse[2] + 0.03);
  EXPECT_NEAR(mine[0].heading_deg, std::sqrt(yaw / n) * 57.3, 0.1);
}

TEST(InsFitness, AgreesWithTheCovarianceAtEveryStep) {
  const Simulated s(20.0);
  InsFitnessOptions o;
  const auto intervals = InsFitness::make(s.drive, o);
  o.covariance_every_step = true;
  const auto every_step = InsFitness::make(s.drive, o);
  ASSERT_TRUE(intervals.has_value() && every_step.has_value());
  auto who = crowd(40);
  for (std::size_t g = 3; g < 6; ++g) who[kInsGenes + g] = 1.0;  // a correlation time of a second
  std::vector<double> a(40), b(40);
  (*every_step)(who, a);
  (*intervals)(who, b);
  // Bounds of the covariances: ComposedSteps.AgreeWithEveryStep, and AgreeForLargeNoise.
  std::vector<double> differences;
  for (std::size_t i = 0; i < a.size(); ++i) differences.push_back(std::abs(b[i] / a[i] - 1.0));
  std::sort(differences.begin(), differences.end());
  EXPECT_LT(differences[20], 2e-6);
  EXPECT_LT(differences.back(), 3e-5);
  EXPECT_EQ(b[1], a[1]) << "too short for intervals";
  EXPECT_NE(b[0], a[0]) << "not by intervals";
  const auto order = [](const std::vector<double>& scores) {
    std::vector<std::size_t> at(scores.size());
    std::iota(at.begin(), at.end(), std::size_t{0});
    std::sort(at.begin(), at.end(), [&](auto i, auto j) { return scores[i] < scores[j]; });
    return at;
  };
  EXPECT_EQ(order(b), order(a));
}

TEST(InsFitness, AppliesTheWeights) {
  InsFitnessWeights w{1.0, 2.0, 3.0, 4.0, 5.0, 6.0};
  EXPECT_DOUBLE_EQ(w.sum({1.0, 1.0, 1.0, 1.0, 1.0, 1.0}), 21.0);
  EXPECT_DOUBLE_EQ(w.sum({0.0, 0.0, 0.0, 0.0, 0.0, 2.0}), 12.0);
}

TEST(InsFitness, ReportsUnusableInput) {
  Simulated s(2.0);
  InsFitnessOptions o;
  o.kernel = "mmx";
  const auto unknown = InsFitness::make(s.drive, o);
  ASSERT_FALSE(unknown.has_value());
  EXPECT_EQ(unknown.error().code, ErrorCode::unsupported);
  s.drive.truth = [](LogTime) { return std::optional<NavState>(); };
  EXPECT_FALSE(InsFitness::make(s.drive).has_value());
  s.drive.imu.clear();
  EXPECT_FALSE(InsFitness::make(s.drive).has_value());
}

}  // namespace
}  // namespace wayfare
