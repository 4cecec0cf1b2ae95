// Allan deviation, Gauss-Markov fit and magnetometer calibration of records that are empty,
// constant, huge or not numbers.

#include <array>
#include <cmath>
#include <limits>
#include <tuple>
#include <vector>

#include <gtest/gtest.h>

#include <wayfare/core/random.hpp>
#include <wayfare/inertial/imu_noise.hpp>
#include <wayfare/inertial/magnetometer_calibration.hpp>

#include "abuse/abuse.hpp"

namespace wayfare {
namespace {

using namespace tests;

void expect_finite(const AllanFit& fit) {
  for (const AllanCoefficient& c :
       {fit.quantisation, fit.random_walk, fit.bias_instability, fit.rate_random_walk})
    EXPECT_TRUE(std::isfinite(c.value) && std::isfinite(c.sigma) && std::isfinite(c.to_s));
  EXPECT_TRUE(std::isfinite(fit.floor) && std::isfinite(fit.floor_tau_s));
}

TEST(AllanAbuse, IgnoresWhatIsNotAReading) {
  Rng rng(1);
  AllanRecorder clean(0.01), abused(0.01);
  AutocorrelationRecorder clean_slow(0.01, 64), abused_slow(0.01, 64);
  for (int i = 0; i < 3000; ++i) {
    for (const double x : {kNan, kInf, -kInf, kHuge, -kHuge}) {
      abused.add(x);
      abused_slow.add(x);
    }
    const double value = rng.normal();
    clean.add(value), abused.add(value);
    clean_slow.add(value), abused_slow.add(value);
  }
  EXPECT_EQ(abused.count(), 3000U);
  EXPECT_EQ(abused.mean(), clean.mean());
  const AllanCurve a = abused.allan(), c = clean.allan();
  ASSERT_EQ(a.size(), c.size());
  for (std::size_t i = 0; i < a.size(); ++i) EXPECT_EQ(a[i].deviation, c[i].deviation);
  EXPECT_EQ(abused_slow.autocorrelation(20), clean_slow.autocorrelation(20));
}

TEST(AllanAbuse, AnyRecordHasAFiniteCurveAndFit) {
  for (const double scale : {0.0, kTiny, 1e-160, 1e9, 1e100}) {
    AllanRecorder recorder(1.0);
    AutocorrelationRecorder slow(1.0, 16);
    expect_finite(fit_allan(recorder.allan()));
    EXPECT_FALSE(slow.fit().found);
    EXPECT_EQ(recorder.mean(), 0.0);
    for (int i = 0; i < 2000; ++i) {
      recorder.add(i % 2 == 0 ? scale : -scale);
      slow.add(i % 2 == 0 ? scale : -scale);
    }
    for (const AllanCurve& curve : {recorder.allan(), recorder.hadamard()}) {
      for (const AllanPoint& p : curve) EXPECT_TRUE(std::isfinite(p.deviation)) << scale;
      expect_finite(fit_allan(curve));
    }
    const GaussMarkovFit fit = slow.fit();
    EXPECT_TRUE(!fit.found || (std::isfinite(fit.sigma) && std::isfinite(fit.tau_s)));
  }
}

TEST(AllanAbuse, CurvesOfAnyPointsAreFitted) {
  AllanCurve good;
  for (int i = 1; i <= 30; ++i) good.push_back({double(i), 1.0 / std::sqrt(i), 0.05});
  const AllanFit expected = fit_allan(good);
  EXPECT_NEAR(expected.random_walk.value, 1.0, 1e-9);  // N = 1 alone: variance 1/τ
  for (const double x : {kNan, kInf, -kInf, kHuge, kTiny, 0.0, -1.0}) {
    AllanCurve curve = good;
    curve.push_back({x, 1.0, 0.05});
    curve.push_back({1.0, x, 0.05});
    const AllanFit fit = fit_allan(curve);
    expect_finite(fit);
    curve = good;
    for (AllanPoint& p : curve) p.relative_sigma = x;
    expect_finite(fit_allan(curve, x));
    curve = good;
    for (AllanPoint& p : curve) p.tau_s = x;
    expect_finite(fit_allan(curve));
  }
  expect_finite(fit_allan({}));
  // The same averaging time again and again.
  expect_finite(fit_allan(AllanCurve(40, {1.0, 1.0, 0.05})));
}

TEST(AllanAbuse, ALongCurveNeedsNoMoreMemoryThanAShortOne) {
  AllanCurve curve;
  for (int i = 1; i <= 1'000'000; ++i) curve.push_back({double(i), 1.0 / std::sqrt(i), 1e-3});
  const AllanFit fit = fit_allan(curve);
  expect_finite(fit);
  EXPECT_NEAR(fit.random_walk.value, 1.0, 1e-9);
}

// All of 500 points are used, every second one of 501: a lowest point at an odd index is left out.
TEST(AllanAbuse, UsesEveryPointOfACurveThatIsNotTooLong) {
  for (const std::size_t size : {std::size_t{3}, std::size_t{500}, std::size_t{501}}) {
    AllanCurve curve;
    for (std::size_t i = 0; i < size; ++i) curve.push_back({1.0 + double(i), 1.0, 0.05});
    curve[1].deviation = 0.5;
    EXPECT_EQ(fit_allan(curve).floor_tau_s == 2.0, size <= 500) << size;
  }
}

TEST(AllanAbuse, ClaimedSizesAreNotAllocated) {
  for (const std::size_t blocks :
       {std::size_t{16}, std::size_t{17}, std::size_t{1'000'000'000},
        std::numeric_limits<std::size_t>::max() - 1, std::numeric_limits<std::size_t>::max()}) {
    AutocorrelationRecorder recorder(1.0, blocks);
    for (int i = 0; i < 15; ++i) recorder.add(i);
    EXPECT_EQ(recorder.block_s(), 1.0) << blocks;
    EXPECT_EQ(recorder.autocorrelation(std::numeric_limits<std::size_t>::max()).size(), 15U);
    EXPECT_TRUE(recorder.autocorrelation(0).empty());
  }
  EXPECT_DEATH(AutocorrelationRecorder(1.0, 15), "at least 16 blocks");
  EXPECT_DEATH(AllanRecorder(0.0), "the sampling period is positive");
  EXPECT_DEATH(AllanRecorder{kNan}, "the sampling period is positive");
}

TEST(AllanAbuse, RecordersAreValues) {
  AllanRecorder recorder(0.1);
  AutocorrelationRecorder slow(0.1, 32);
  Rng rng(3);
  for (int i = 0; i < 500; ++i) recorder.add(rng.normal()), slow.add(rng.normal());
  expect_value_semantics(recorder, [](AllanRecorder& r) {
    for (int i = 0; i < 100; ++i) r.add(i % 7);
    return std::tuple(r.count(), r.mean(), r.allan().back().deviation);
  });
  expect_value_semantics(slow, [](AutocorrelationRecorder& r) {
    for (int i = 0; i < 100; ++i) r.add(i % 7);
    return r.autocorrelation(10);
  });
}

std::vector<Eigen::Vector3d> sphere(std::size_t count, double radius) {
  Rng rng(6);
  std::vector<Eigen::Vector3d> all;
  for (std::size_t i = 0; i < count; ++i)
    all.push_back(radius * Eigen::Vector3d(rng.normal(), rng.normal(), rng.normal()).normalized() +
                  Eigen::Vector3d::Constant(0.1 * radius));
  return all;
}

TEST(MagnetometerCalibrationAbuse, AnswersWithAFiniteCalibrationOrAnError) {
  for (const double radius : {0.0, kTiny, 1e-160, 1e-9, 50.0, 1e9, 1e100, kHuge}) {
    for (const std::size_t count :
         {std::size_t{0}, std::size_t{1}, std::size_t{49}, std::size_t{400}}) {
      const auto c = calibrate_magnetometer(sphere(count, radius));
      if (radius == 50.0 || radius == 1e9 || radius == 1e-9) {
        EXPECT_EQ(c.has_value(), count == 400) << radius;
      }
      if (!c) continue;
      EXPECT_TRUE(c->correction.allFinite() && c->offset_uT.allFinite()) << radius;
      EXPECT_TRUE(c->offset_sigma_uT.allFinite() && std::isfinite(c->field_uT)) << radius;
    }
  }
}

TEST(MagnetometerCalibrationAbuse, RepeatedAndDegenerateReadingsAreErrors) {
  const std::vector<Eigen::Vector3d> same(10'000, {20.0, 1.0, 40.0});
  EXPECT_EQ(calibrate_magnetometer(same).error().code, ErrorCode::degenerate);
  std::vector<Eigen::Vector3d> two;
  for (int i = 0; i < 1000; ++i)
    two.push_back(i % 2 == 0 ? Eigen::Vector3d(50, 0, 0) : Eigen::Vector3d(0, 50, 0));
  EXPECT_FALSE(calibrate_magnetometer(two));
  std::vector<Eigen::Vector3d> none(1000, Eigen::Vector3d::Constant(kNan));
  EXPECT_FALSE(calibrate_magnetometer(none));
  MagnetometerCalibrationOptions nothing_needed;
  nothing_needed.least_readings = 0;
  EXPECT_FALSE(calibrate_magnetometer({}, nothing_needed));
  // One reading far off hides among many.
  auto one = sphere(400, 50.0);
  one[200].setConstant(1e9);
  const auto c = calibrate_magnetometer(one);
  EXPECT_TRUE(!c || c->correction.allFinite());
  for (const double field : {kNan, -1.0, 0.0}) {
    MagnetometerCalibrationOptions o;
    o.field_uT = field;
    const auto scaled = calibrate_magnetometer(sphere(400, 50.0), o);
    ASSERT_TRUE(scaled);
    EXPECT_NEAR(scaled->field_uT, 50.0, 1.0);
  }
}

TEST(InertialRecordsAbuse, TwoThreads) {
  const auto results = in_two_threads([](int) {
    AllanRecorder recorder(0.1);
    AutocorrelationRecorder slow(0.1, 64);
    Rng rng(3);
    double walk = 0.0;
    for (int i = 0; i < 5000; ++i) {
      walk = 0.99 * walk + rng.normal();
      recorder.add(walk), slow.add(walk);
    }
    return std::tuple(fit_allan(recorder.allan()).floor, slow.fit().tau_s,
                      calibrate_magnetometer(sphere(300, 40.0))->residual_uT);
  });
  EXPECT_EQ(results[0], results[1]);
}

}  // namespace
}  // namespace wayfare
