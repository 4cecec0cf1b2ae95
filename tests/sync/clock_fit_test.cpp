#include <wayfare/sync/clock_fit.hpp>

#include <cmath>

#include <gtest/gtest.h>

#include <wayfare/core/random.hpp>

namespace wayfare {
namespace {

struct DeviceClock {};
using Pair = ClockPair<DeviceClock>;

constexpr double kRate = 1.0 + 40e-6, kOffset_s = 123456.789;

Time<DeviceClock> device(double s) { return Time<DeviceClock>::from_seconds(s); }

/// The device's instant `s` on the log's clock, exact to the nanosecond.
LogTime truth(double s) {
  return LogTime::from_seconds(kOffset_s) + from_seconds(s) + from_seconds((kRate - 1.0) * s);
}

template <class Delay>
std::vector<Pair> pairs(int count, double step_s, Delay&& delay) {
  std::vector<Pair> result;
  for (int i = 0; i < count; ++i) {
    const double s = 1000.0 + step_s * i;
    result.push_back({device(s), truth(s) + from_seconds(delay(i))});
  }
  return result;
}

double error_s(const ClockFit<DeviceClock>& fit, double s) {
  return to_seconds(fit(device(s)) - truth(s));
}

TEST(ClockFit, FindsOffsetAndRateOfCleanStamps) {
  const auto fit = fit_clock<DeviceClock>(pairs(200, 5.0, [](int) { return 0.0; }));
  ASSERT_TRUE(fit);
  EXPECT_NEAR(fit->rate, kRate, 1e-12);
  EXPECT_GE(fit->used,
            180U);  // the stamps are rounded to nanoseconds, so that some exceed the gate
  for (const double s : {0.0, 1000.0, 1500.0, 2000.0, 1e5}) EXPECT_NEAR(error_s(*fit, s), 0, 1e-7);
}

// n stamps of noise σ over a length L determine the rate to σ√(12/n)/L and the middle to σ/√n.
TEST(ClockFit, RejectsOutliers) {
  Rng rng(3);
  constexpr double kNoise_s = 1e-4;
  const auto noisy = pairs(1000, 1.0, [&](int i) {
    const double noise = rng.normal(0.0, kNoise_s);
    return i % 50 == 7 ? 3.0 + noise : noise;  // a fiftieth are seconds off, all to one side
  });
  const auto fit = fit_clock<DeviceClock>(noisy);
  ASSERT_TRUE(fit);
  EXPECT_LE(fit->used, 980U);
  EXPECT_GE(fit->used, 940U);
  EXPECT_NEAR(fit->rate, kRate, 4.0 * kNoise_s * std::sqrt(12.0 / 1000.0) / 1000.0);
  EXPECT_NEAR(error_s(*fit, 1500.0), 0.0, 4.0 * kNoise_s / std::sqrt(1000.0));
  EXPECT_NEAR(fit->residual_s, kNoise_s, 0.1 * kNoise_s);
}

// Delays are exponential with a mean of 20 ms: the mean of the stamps is 20 ms late, the line
// through the earliest ones much less.
TEST(ClockFit, FitsTheEarliestOfLateStamps) {
  Rng rng(4);
  const auto late = pairs(5000, 0.2, [&](int) { return -0.02 * std::log(1.0 - rng.uniform()); });
  const auto middle = fit_clock<DeviceClock>(late);
  const auto punctual = fit_clock<DeviceClock>(late, {.late = true});
  ASSERT_TRUE(middle && punctual);
  EXPECT_NEAR(error_s(*middle, 1500.0), 0.018, 0.004);  // the gate rejects the longest delays
  EXPECT_LT(error_s(*punctual, 1500.0), 0.006);
  EXPECT_GT(error_s(*punctual, 1500.0), 0.0);
  EXPECT_NEAR(punctual->rate, kRate, 5e-6);
  EXPECT_GE(punctual->used, 500U);
}

TEST(ClockFit, DoesNotDependOnTheClocksEpochs) {
  auto stamps = pairs(100, 1.0, [](int i) { return i % 2 == 0 ? 1e-3 : -1e-3; });
  const auto fit = fit_clock<DeviceClock>(stamps);
  for (Pair& p : stamps) p.device += std::chrono::hours(24 * 365 * 50);
  const auto moved = fit_clock<DeviceClock>(stamps);
  ASSERT_TRUE(fit && moved);
  EXPECT_EQ(fit->rate, moved->rate);
  EXPECT_EQ((*moved)(stamps[50].device), (*fit)(device(1050.0)));
}

TEST(ClockFit, RequiresTwoInstants) {
  EXPECT_FALSE(fit_clock<DeviceClock>({}));
  const auto one = pairs(1, 1.0, [](int) { return 0.0; });
  EXPECT_FALSE(fit_clock<DeviceClock>(one));
  const std::vector<Pair> same(5, one.front());
  const auto fit = fit_clock<DeviceClock>(same);
  ASSERT_FALSE(fit);
  EXPECT_EQ(fit.error().code, ErrorCode::degenerate);
  const auto two = fit_clock<DeviceClock>(pairs(2, 1.0, [](int) { return 0.0; }));
  ASSERT_TRUE(two);
  EXPECT_NEAR(two->rate, kRate, 1e-8);  // of nanoseconds over a second
}

}  // namespace
}  // namespace wayfare
