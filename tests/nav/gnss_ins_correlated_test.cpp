// Correlated errors of ranges and fixes, and outliers, on simulated drives of 310 s.

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include <wayfare/core/random.hpp>
#include <wayfare/eval/consistency.hpp>
#include <wayfare/eval/nav_error.hpp>
#include <wayfare/filter/gauss_markov.hpp>
#include <wayfare/sim/gnss.hpp>
#include <wayfare/sim/ins_monte_carlo.hpp>

namespace wayfare::sim {
namespace {

InsMonteCarloOptions with_errors(double share, double tau_s) {
  InsMonteCarloOptions o;
  o.imu.period = std::chrono::milliseconds(20);
  o.ranges.max_satellites = 8;
  o.ranges.correlated_share = share;
  o.ranges.correlated_tau_s = tau_s;
  o.filter.zero_velocity_updates = false;
  o.filter.non_holonomic_in_outage = false;
  o.filter.correlated = {share, tau_s, 1e9};
  o.threads = 2;
  return o;
}

struct CorrelatedOutcome {
  double nees = 0.0, position_rms_m = 0.0;
};

CorrelatedOutcome judge(const InsMonteCarloOptions& options) {
  CorrelatedOutcome o;
  double count = 0.0;
  for (const InsErrorSeries& run :
       ins_monte_carlo(demo_drive(), gps_and_galileo(), 12, options, Rng(3)))
    for (const InsErrorAt& at : run) {
      o.nees += at.navigation_nees;
      o.position_rms_m += at.error.head<3>().squaredNorm();
      ++count;
    }
  return {o.nees / count, std::sqrt(o.position_rms_m / count)};
}

// The mean NEES of nine states over twelve drives has a standard error of 4 % for white noise (0.11
// of 9 over a hundred: see the report on consistency), and of 12 % where errors of a minute leave a
// third of the samples; three of these.
TEST(GnssInsCorrelated, ErrorsOfRangesMatchTheCovarianceOnlyIfTheyAreModelled) {
  InsMonteCarloOptions options = with_errors(0.9, 60.0);
  const CorrelatedOutcome modelled = judge(options);
  options.filter.correlated = {};
  const CorrelatedOutcome as_white = judge(options);
  EXPECT_NEAR(modelled.nees, 9.0, 0.36 * 9.0);
  EXPECT_GT(as_white.nees, 3.0 * 9.0);
  EXPECT_LT(modelled.position_rms_m, as_white.position_rms_m);
}

TEST(GnssInsCorrelated, SimulatedErrorsHaveTheirVarianceAndCorrelation) {
  RangeParams params;
  params.range_sigma_m = 2.0;
  params.correlated_share = 1.0;
  params.correlated_tau_s = 20.0;
  RangeParams exact = params;
  exact.range_sigma_m = 1e-12;
  const auto drive = demo_drive();
  const auto noisy = simulate_ranges(drive, gps_and_galileo(), params, Rng(5));
  const auto truth = simulate_ranges(drive, gps_and_galileo(), exact, Rng(5));
  double squares = 0.0, products = 0.0, count = 0.0;
  const auto error = [&](std::size_t k, std::size_t i) {
    return noisy.epochs[k].satellites[i].range_m - truth.epochs[k].satellites[i].range_m;
  };
  for (std::size_t k = 0; k + 1 < noisy.epochs.size(); ++k) {
    const auto &now = noisy.epochs[k].satellites, &next = noisy.epochs[k + 1].satellites;
    if (now.size() != next.size()) continue;
    for (std::size_t i = 0; i < now.size(); ++i) {
      if (now[i].satellite != next[i].satellite) continue;
      squares += error(k, i) * error(k, i), products += error(k, i) * error(k + 1, i), ++count;
    }
  }
  // 16 satellites for 310 s of 20 s: some 120 independent values, a standard error of 13 %.
  EXPECT_NEAR(squares / count, 4.0, 3.0 * 0.13 * 4.0);
  EXPECT_NEAR(products / squares, std::exp(-1.0 / 20.0), 0.02);
}

/// Mean over drives of the NEES of the position by fixes with Gauss-Markov errors.
double nees_of_fixes(const CorrelatedErrorOptions& correlated) {
  const double sigma_m = 3.0, tau_s = 40.0;
  double sum = 0.0, count = 0.0;
  for (std::uint64_t run = 0; run < 8; ++run) {
    const auto drive = demo_drive();
    Rng rng = Rng(17).stream(run);
    ImuParams imu;
    imu.period = std::chrono::milliseconds(20);
    SimulatedUnit unit(drive, imu, rng.stream(0));
    GnssInsOptions options;
    options.imu = imu.noise;
    options.zero_velocity_updates = options.non_holonomic_in_outage = false;
    options.correlated = correlated;
    GnssIns filter(options);
    GnssInsStart start;
    start.position_sigma_m = 100.0;
    filter.start(drawn_start(drive.state(drive.begin()), start, rng));
    const auto step = discretise_gauss_markov(sigma_m, tau_s, 1.0);
    Eigen::Vector3d error = sigma_m * Eigen::Vector3d(rng.normal(), rng.normal(), rng.normal());
    LogTime next = drive.begin();
    for (ImuSample s; unit.read(s);) {
      EXPECT_TRUE(filter.add(s));
      if (s.time < next || !filter.started()) continue;
      const NavState truth = drive.state(s.time);
      const Eigen::Vector3d noise(rng.normal(), rng.normal(), rng.normal());
      error = step.phi * error + std::sqrt(step.q) * noise;
      GnssFix fix{s.time, geodetic_from_ned(error, truth.position),
                  sigma_m * sigma_m * Eigen::Matrix3d::Identity(), std::nullopt};
      EXPECT_TRUE(filter.add(fix));
      next += std::chrono::seconds(1);
      const GnssInsEstimate e = filter.estimate();
      sum += eval::normalised_squared(eval::nav_error(e.nav, truth).position_ned_m.eval(),
                                      e.covariance.topLeftCorner<3, 3>().eval());
      ++count;
    }
  }
  return sum / count;
}

// Eight drives of 310 s with errors of 40 s: about 30 independent values of three numbers each, a
// standard error of 3 √(2 / 90) = 0.45.
TEST(GnssInsCorrelated, ErrorsOfFixesMatchTheCovarianceOnlyIfTheyAreModelled) {
  EXPECT_NEAR(nees_of_fixes({1.0, 40.0, 1e9}), 3.0, 3.0 * 0.45);
  EXPECT_GT(nees_of_fixes({}), 10.0);
}

/// A filter after a minute of ranges, and the next epoch.
struct Minute {
  explicit Minute(double robust_sigma) : filter(options(robust_sigma)) {
    const auto drive = demo_drive();
    const ImuParams imu;
    SimulatedUnit unit(drive, imu, Rng(2));
    RangeParams params;
    params.max_satellites = 8;
    const auto ranges = simulate_ranges(drive, gps_and_galileo(), params, Rng(4));
    GnssInsStart start;
    start.nav = drive.state(drive.begin());
    filter.start(start);
    std::size_t k = 1;
    for (ImuSample s; unit.read(s);) {
      EXPECT_TRUE(filter.add(s));
      if (s.time < ranges.epochs[k].time) continue;
      if (k == 60) break;
      EXPECT_TRUE(filter.add(ranges.epochs[k++]));
    }
    next = ranges.epochs[k];
    next.satellites.resize(1);
  }
  static GnssInsOptions options(double robust_sigma) {
    GnssInsOptions o;
    o.robust_sigma = robust_sigma;
    o.gate_sigma = 1e3;
    return o;
  }
  /// Variance of the position before and after a range that is longer by `excess_m`.
  [[nodiscard]] double shrinking(double excess_m) const {
    GnssIns after = filter;
    RangeEpoch epoch = next;
    epoch.satellites[0].range_m += excess_m;
    epoch.satellites[0].range_rate_mps = std::numeric_limits<double>::quiet_NaN();
    EXPECT_TRUE(after.add(epoch));
    const auto variance = [](const GnssIns& f) {
      return f.estimate().covariance.topLeftCorner<3, 3>().trace();
    };
    return 1.0 - variance(after) / variance(filter);
  }

  GnssIns filter;
  RangeEpoch next;
};

TEST(GnssInsCorrelated, AnOutlierDoesNotMakeTheEstimateMoreCertain) {
  const Minute robust(3.0), plain(0.0);
  EXPECT_GT(robust.shrinking(0.0), 1e-3);                          // a good range does
  EXPECT_NEAR(robust.shrinking(0.0), plain.shrinking(0.0), 1e-9);  // as without weights
  EXPECT_LT(robust.shrinking(200.0), 0.01 * robust.shrinking(0.0));
  EXPECT_NEAR(plain.shrinking(200.0), plain.shrinking(0.0), 0.1 * plain.shrinking(0.0));
}

TEST(GnssInsCorrelated, ParametersThatAreNotUsableAreRefused) {
  GnssInsRecording recording;
  recording.imu.resize(1);
  recording.start.emplace();
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const CorrelatedErrorOptions& bad :
       {CorrelatedErrorOptions{-0.1, 1.0, 1.0}, CorrelatedErrorOptions{1.1, 1.0, 1.0},
        CorrelatedErrorOptions{0.5, 0.0, 1.0}, CorrelatedErrorOptions{0.5, 1.0, -1.0},
        CorrelatedErrorOptions{nan, 1.0, 1.0}, CorrelatedErrorOptions{0.5, nan, 1.0}}) {
    GnssInsOptions options;
    options.correlated = bad;
    const auto run = run_gnss_ins(recording, options);
    ASSERT_FALSE(run);
    EXPECT_EQ(run.error().code, ErrorCode::invalid);
    EXPECT_NE(run.error().message.find("share within [0, 1]"), std::string::npos);
  }
  GnssInsOptions options;
  options.robust_sigma = -1.0;
  EXPECT_FALSE(run_gnss_ins(recording, options));
  options = {};
  options.correlated.share = 0.5;
  const auto smoothed = smooth_gnss_ins(recording, options);
  ASSERT_FALSE(smoothed);
  EXPECT_NE(smoothed.error().message.find("cannot be smoothed"), std::string::npos);
}

}  // namespace
}  // namespace wayfare::sim
