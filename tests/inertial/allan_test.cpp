#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include <wayfare/core/random.hpp>
#include <wayfare/inertial/imu_noise.hpp>

namespace wayfare {
namespace {

std::vector<double> white(std::size_t n, double sigma, std::uint64_t seed) {
  Rng rng(seed);
  std::vector<double> x(n);
  for (double& v : x) v = sigma * rng.normal();
  return x;
}

/// By the definition: means of m readings, m apart, starting at every reading.
double direct_allan(const std::vector<double>& x, std::size_t m, bool hadamard) {
  const auto mean = [&](std::size_t i) {
    double sum = 0.0;
    for (std::size_t k = 0; k < m; ++k) sum += x[i + k];
    return sum / static_cast<double>(m);
  };
  double squares = 0.0;
  std::size_t n = 0;
  for (std::size_t i = 0; i + (hadamard ? 3 : 2) * m <= x.size(); ++i, ++n) {
    const double d =
        hadamard ? mean(i + 2 * m) - 2.0 * mean(i + m) + mean(i) : mean(i + m) - mean(i);
    squares += d * d;
  }
  return std::sqrt(squares / ((hadamard ? 6.0 : 2.0) * static_cast<double>(n)));
}

TEST(Allan, EqualsTheDefinitionUpTo64Readings) {
  const auto x = white(700, 1.0, 3);
  AllanRecorder recorder(0.5);
  for (const double v : x) recorder.add(v + 1e3);
  for (const bool hadamard : {false, true}) {
    for (const AllanPoint& p : hadamard ? recorder.hadamard() : recorder.allan()) {
      if (p.tau_s > 32.0) break;
      const auto m = static_cast<std::size_t>(std::lround(p.tau_s / 0.5));
      EXPECT_NEAR(p.deviation, direct_allan(x, m, hadamard), 1e-9) << m;
    }
  }
}

TEST(Allan, LongAveragesAgreeWithFullOverlap) {
  const auto x = white(20000, 1.0, 4);
  AllanRecorder recorder(1.0);
  for (const double v : x) recorder.add(v);
  int compared = 0;
  for (const AllanPoint& p : recorder.allan()) {
    if (p.tau_s < 65.0 || p.tau_s > 1100.0) continue;
    const double every = direct_allan(x, static_cast<std::size_t>(std::lround(p.tau_s)), false);
    EXPECT_NEAR(p.deviation, every, 0.02 * every) << p.tau_s;
    ++compared;
  }
  EXPECT_GE(compared, 12);
}

TEST(Allan, OfWhiteNoiseFallsWithTheSquareRootOfTime) {
  AllanRecorder recorder(0.01);
  for (const double v : white(200000, 2.0, 5)) recorder.add(v);
  for (const AllanPoint& p : recorder.allan()) {
    const double expected = 2.0 * std::sqrt(0.01 / p.tau_s);
    EXPECT_NEAR(p.deviation / expected, 1.0, 4.0 * p.relative_sigma + 1e-3) << p.tau_s;
  }
}

TEST(Allan, OfARampIsItsSlopeAndHadamardIsZero) {
  AllanRecorder recorder(2.0);
  for (int i = 0; i < 5000; ++i) recorder.add(0.25 * 2.0 * i);
  for (const AllanPoint& p : recorder.allan())
    EXPECT_NEAR(p.deviation, 0.25 * p.tau_s / std::numbers::sqrt2, 1e-6 * p.tau_s);
  for (const AllanPoint& p : recorder.hadamard()) EXPECT_LT(p.deviation, 1e-9 * p.tau_s);
}

/// White noise N, flicker noise B, random walk K. Flicker noise is a sum of Gauss-Markov processes
/// of equal variance B² ln r/π with correlation times in ratio r: its density over their band is
/// B²/(2πf).
struct Mixed {
  double n, b, k;
  [[nodiscard]] AllanFit fit(std::size_t count, std::uint64_t seed) const {
    Rng rng(seed);
    constexpr double kRatio = 3.0;
    std::vector<double> times, states;
    for (double t = 0.3; t < 10.0 * static_cast<double>(count); t *= kRatio) times.push_back(t);
    const double sigma = b * std::sqrt(std::log(kRatio) / std::numbers::pi);
    for (std::size_t i = 0; i < times.size(); ++i) states.push_back(sigma * rng.normal());
    AllanRecorder recorder(1.0);
    double walk = 0.0;
    std::vector<double> keep, fresh;
    for (const double t : times) {
      keep.push_back(std::exp(-1.0 / t));
      fresh.push_back(sigma * std::sqrt(1.0 - keep.back() * keep.back()));
    }
    for (std::size_t i = 0; i < count; ++i) {
      double flicker = 0.0;
      for (std::size_t j = 0; j < states.size(); ++j) {
        states[j] = keep[j] * states[j] + fresh[j] * rng.normal();
        flicker += states[j];
      }
      walk += k * rng.normal();
      recorder.add(5.0 + n * rng.normal() + flicker + walk);
    }
    return fit_allan(recorder.allan());
  }
};

TEST(Allan, RecoversSyntheticCoefficients) {
  // White noise dominates to 10 s, the random walk from about 200 s, of 300 000 s.
  const Mixed truth{2.0, 1.0, 0.08};
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const AllanFit fit = truth.fit(300000, seed);
    EXPECT_NEAR(fit.random_walk.value, truth.n, 0.10 * truth.n) << seed;
    EXPECT_NEAR(fit.bias_instability.value, truth.b, 0.15 * truth.b) << seed;
    EXPECT_NEAR(fit.rate_random_walk.value, truth.k, 0.15 * truth.k) << seed;
    EXPECT_NEAR(fit.rate_random_walk.value, truth.k, 4.0 * fit.rate_random_walk.sigma) << seed;
    EXPECT_GT(fit.rate_random_walk.sigma, 0.0);
  }
}

TEST(Allan, FindsOnlyWhiteNoiseInWhiteNoise) {
  AllanRecorder recorder(0.01);
  for (const double v : white(300000, 1.0, 9)) recorder.add(v);
  const AllanFit fit = fit_allan(recorder.allan());
  EXPECT_NEAR(fit.random_walk.value, 0.1, 0.01);
  EXPECT_LT(fit.rate_random_walk.value, 3e-4);  // 1/300 of the noise at 100 s
  EXPECT_EQ(fit.random_walk.from_s, 0.01);
}

TEST(Allan, EmptyAndConstantRecords) {
  const AllanRecorder none(0.01);
  EXPECT_TRUE(none.allan().empty());
  EXPECT_EQ(fit_allan(none.allan()).random_walk.value, 0.0);
  AllanRecorder constant(0.01);
  for (int i = 0; i < 1000; ++i) constant.add(7.0);
  constant.add(std::numeric_limits<double>::quiet_NaN());
  EXPECT_EQ(constant.count(), 1000U);
  EXPECT_EQ(constant.mean(), 7.0);
  EXPECT_EQ(fit_allan(constant.allan()).random_walk.value, 0.0);
}

TEST(GaussMarkovFit, RecoversSigmaAndTimeUnderWhiteNoise) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    constexpr double kSigma = 0.3, kTau_s = 50.0, kPeriod_s = 0.25;
    Rng rng(seed);
    const double keep = std::exp(-kPeriod_s / kTau_s);
    double x = kSigma * rng.normal();
    AutocorrelationRecorder recorder(kPeriod_s, 8192);
    for (int i = 0; i < 100000; ++i) {  // 500 τ
      x = keep * x + kSigma * std::sqrt(1.0 - keep * keep) * rng.normal();
      recorder.add(2.0 + x + 0.6 * rng.normal());
    }
    const GaussMarkovFit fit = recorder.fit();
    ASSERT_TRUE(fit.found);
    EXPECT_NEAR(fit.sigma, kSigma, 0.3 * kSigma) << seed;
    EXPECT_NEAR(fit.tau_s, kTau_s, 0.3 * kTau_s) << seed;
    EXPECT_NEAR(fit.sigma, kSigma, 4.0 * fit.sigma_sigma) << seed;
    EXPECT_NEAR(fit.tau_s, kTau_s, 4.0 * fit.tau_sigma_s) << seed;
  }
}

TEST(GaussMarkovFit, AutocorrelationOfBlockMeans) {
  // Readings 0, 1, 2, 3 repeated: means of two are 0.5 and 2.5, ±1 about their mean.
  AutocorrelationRecorder recorder(1.0, 16);
  for (int i = 0; i < 16; ++i) recorder.add(i % 4);
  EXPECT_EQ(recorder.block_s(), 2.0);
  const auto r = recorder.autocorrelation(3);
  ASSERT_EQ(r.size(), 3U);
  EXPECT_DOUBLE_EQ(r[0], 1.0);
  EXPECT_DOUBLE_EQ(r[1], -1.0);
  EXPECT_DOUBLE_EQ(r[2], 1.0);
}

TEST(GaussMarkovFit, RampAndEmptyRecord) {
  AutocorrelationRecorder ramp(1.0);
  for (int i = 0; i < 1000; ++i) ramp.add(i);
  const GaussMarkovFit of_ramp = ramp.fit();
  // A trend looks like a process slower than the record.
  EXPECT_TRUE(!of_ramp.found || of_ramp.tau_s > 100.0);
  AutocorrelationRecorder empty(1.0);
  EXPECT_FALSE(empty.fit().found);
}

}  // namespace
}  // namespace wayfare
