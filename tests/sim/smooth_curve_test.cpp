#include <wayfare/sim/detail/smooth_curve.hpp>

#include <cmath>

#include <gtest/gtest.h>

namespace wayfare::sim {
namespace {

Eigen::Vector3d quadratic(double t) { return {1 + 2 * t, 3 - t * t, 0.5 * t * t + t}; }

TEST(SmoothCurve, IsExactForQuadraticsFromValuesOrDerivatives) {
  // A quadratic has no third derivative, so its cost is zero: it is the minimiser.
  std::vector<CurveSample> samples;
  for (const double t : {0.1, 1.7, 4.0}) samples.push_back({t, quadratic(t), 0.1});
  samples.push_back({3.3, {2, -6.6, 4.3}, 0.2, CurveSample::Of::derivative});
  const auto curve = SmoothCurve::fit(samples, 0.0, 5.0, {0.5, 2.0});
  ASSERT_TRUE(curve);
  for (double t = 0; t <= 5.0; t += 0.07) {
    const auto p = curve->at(t);
    EXPECT_LT((p.value - quadratic(t)).norm(), 1e-8);
    EXPECT_LT((p.first - Eigen::Vector3d(2, -2 * t, t + 1)).norm(), 1e-8);
    EXPECT_LT((p.second - Eigen::Vector3d(0, -2, 1)).norm(), 1e-8);
  }
}

TEST(SmoothCurve, ConvergesWithTheFourthPowerOfTheSpacing) {
  // The error of cubic spline interpolation is of order h⁴: a sixteenth at half the spacing.
  const auto error = [](double h) {
    std::vector<CurveSample> samples;
    const int n = static_cast<int>(std::lround(10 / h));
    for (int i = 0; i <= n; ++i)
      samples.push_back({i * h, {std::sin(i * h), std::cos(i * h), 0}, 1e-6});
    const auto curve = SmoothCurve::fit(samples, 0, 10, {h, 1e3});
    double worst = 0;
    for (double t = 2; t < 8; t += 0.013)
      worst = std::max(worst, std::abs(curve->at(t).value.x() - std::sin(t)));
    return worst;
  };
  EXPECT_NEAR(error(0.4) / error(0.2), 16.0, 3.0);
}

TEST(SmoothCurve, DerivativesAreThoseOfTheValue) {
  std::vector<CurveSample> samples;
  for (int i = 0; i <= 20; ++i) samples.push_back({0.5 * i, {std::sin(0.5 * i), 0, 0}, 0.01});
  const auto curve = SmoothCurve::fit(samples, 0, 10, {0.5, 1.0});
  ASSERT_TRUE(curve);
  for (double t = 0.1; t < 9.9; t += 0.11) {
    const double h = 1e-5;
    const auto a = curve->at(t - h), b = curve->at(t + h);
    EXPECT_NEAR((b.value.x() - a.value.x()) / (2 * h), curve->at(t).first.x(), 1e-8);
    EXPECT_NEAR((b.first.x() - a.first.x()) / (2 * h), curve->at(t).second.x(), 1e-5);
  }
}

TEST(SmoothCurve, IsConstantOutside) {
  std::vector<CurveSample> samples;
  for (int i = 0; i <= 4; ++i) samples.push_back({1.0 * i, {1.0 * i, 0, 0}, 0.1});
  const auto curve = SmoothCurve::fit(samples, 0, 4, {1.0, 1.0});
  ASSERT_TRUE(curve);
  EXPECT_NEAR(curve->at(99).value.x(), 4.0, 1e-9);
  EXPECT_EQ(curve->at(99).first.x(), 0.0);
  EXPECT_NEAR(curve->at(-1).value.x(), 0.0, 1e-9);
}

TEST(SmoothCurve, RefusesUnderdeterminedSamples) {
  const CurveSample one{1.0, {1, 2, 3}, 0.1};
  std::vector<CurveSample> samples(2, one);
  EXPECT_FALSE(SmoothCurve::fit(samples, 0, 5));
  samples.push_back(one);
  EXPECT_FALSE(SmoothCurve::fit(samples, 5, 5));
  EXPECT_FALSE(SmoothCurve::fit(samples, 0, NAN));
  samples.back().value.y() = NAN;
  EXPECT_FALSE(SmoothCurve::fit(samples, 0, 5));
}

}  // namespace
}  // namespace wayfare::sim
