#include <wayfare/core/dual.hpp>

#include <cmath>
#include <functional>

#include <gtest/gtest.h>

#include <wayfare/core/random.hpp>
#include <wayfare/core/se3.hpp>

namespace wayfare {
namespace {

using Dual2 = Dual<double, 2>;

/// The derivatives of f(x, y) by dual numbers are those by central differences.
template <class F>
void expect_derivatives(const char* name, const F& f, double low, double high) {
  Rng rng(1);
  for (int i = 0; i < 100; ++i) {
    const double x = low + (high - low) * rng.uniform(), y = low + (high - low) * rng.uniform();
    const Dual2 got = f(Dual2::variable(x, 0), Dual2::variable(y, 1));
    constexpr double kStep = 1e-6;
    const auto value = [&](double a, double b) { return Dual2(f(Dual2(a), Dual2(b))).value; };
    EXPECT_EQ(got.value, value(x, y)) << name;
    EXPECT_NEAR(got.derivatives[0], (value(x + kStep, y) - value(x - kStep, y)) / (2 * kStep),
                1e-7 * (1 + std::abs(got.derivatives[0])))
        << name << " by x at " << x << ", " << y;
    EXPECT_NEAR(got.derivatives[1], (value(x, y + kStep) - value(x, y - kStep)) / (2 * kStep),
                1e-7 * (1 + std::abs(got.derivatives[1])))
        << name << " by y at " << x << ", " << y;
  }
}

TEST(Dual, FunctionsHaveTheirDerivatives) {
  expect_derivatives(
      "sums", [](auto x, auto y) { return (x + 2.0 * y) - (3.0 - x) - (-y); }, -2, 2);
  expect_derivatives(
      "products", [](auto x, auto y) { return x * y * x / (y + 5.0) / 2.0; }, -2, 2);
  expect_derivatives(
      "assignments",
      [](auto x, auto y) {
        x += y;
        x *= y;
        x -= y * y;
        x /= y + 4.0;
        return x;
      },
      -2, 2);
  expect_derivatives(
      "roots", [](auto x, auto y) { return sqrt(x) * hypot(x, y) + pow(y, 1.5); }, 0.1, 3);
  expect_derivatives(
      "logarithms", [](auto x, auto y) { return exp(x) * log(y); }, 0.1, 3);
  expect_derivatives(
      "angles", [](auto x, auto y) { return sin(x) * cos(y) + tan(x) + atan(y); }, -1, 1);
  expect_derivatives(
      "inverses", [](auto x, auto y) { return asin(x) + acos(y) + atan2(x, y + 2.0); }, -0.9, 0.9);
  expect_derivatives(
      "sizes", [](auto x, auto y) { return abs(x) * y + floor(x) * y; }, 0.1, 0.9);
}

TEST(Dual, FunctionsHaveTheirValues) {
  const double x = 0.4, y = 0.7;
  const Dual2 a = Dual2::variable(x, 0), b = Dual2::variable(y, 1);
  EXPECT_EQ(sin(a).value, std::sin(x));
  EXPECT_EQ(cos(a).value, std::cos(x));
  EXPECT_EQ(tan(a).value, std::tan(x));
  EXPECT_EQ(asin(a).value, std::asin(x));
  EXPECT_EQ(acos(a).value, std::acos(x));
  EXPECT_EQ(atan(a).value, std::atan(x));
  EXPECT_EQ(atan2(a, b).value, std::atan2(x, y));
  EXPECT_EQ(hypot(a, b).value, std::hypot(x, y));
  EXPECT_EQ(pow(a, 2.5).value, std::pow(x, 2.5));
  EXPECT_EQ(sqrt(a).value, std::sqrt(x));
  EXPECT_EQ(exp(a).value, std::exp(x));
  EXPECT_EQ(log(a).value, std::log(x));
  EXPECT_EQ(floor(a - 2.0).value, -2.0);
}

TEST(Dual, SlopesOfTheAbsoluteValue) {
  for (const double x : {-0.5, 0.0, 0.5}) {
    const Dual2 size = abs(Dual2::variable(x, 0));
    EXPECT_EQ(size.value, std::abs(x));
    EXPECT_EQ(size.derivatives[0], x < 0.0 ? -1.0 : 1.0) << x;
  }
}

TEST(Dual, ComparesByValue) {
  const Dual2 a = Dual2::variable(1.0, 0), b(1.0);
  EXPECT_EQ(a, b);
  EXPECT_LT(a, 2.0);
  EXPECT_FALSE(isfinite(sqrt(Dual2::variable(0.0, 0)))) << "the slope is infinite";
}

TEST(Dual, PowersAtZero) {
  const Dual2 zero = Dual2::variable(0.0, 0);
  for (const double exponent : {0.0, 1.0, 2.0}) {
    EXPECT_EQ(pow(zero, exponent).value, exponent == 0.0 ? 1.0 : 0.0);
    EXPECT_EQ(pow(zero, exponent).derivatives[0], exponent == 1.0 ? 1.0 : 0.0);
  }
}

// Derivative of the logarithm: the inverse of the right Jacobian (Sola, Deray, Atchuthan, (144)).
TEST(Dual, GoThroughTheLieGroups) {
  using D = Dual<double, 6>;
  const SE3d x = SE3d::exp((Eigen::Matrix<double, 6, 1>() << 1, 2, 3, 0.4, 0.5, 0.6).finished());
  Eigen::Matrix<D, 6, 1> step;
  for (int i = 0; i < 6; ++i) step[i] = D::variable(0.0, i);
  const auto log = x.cast<D>().plus(step).log();
  const auto want = SE3d::right_jacobian_inverse(x.log());
  for (int row = 0; row < 6; ++row)
    EXPECT_TRUE(log[row].derivatives.transpose().isApprox(want.row(row), 1e-12)) << row;
}

}  // namespace
}  // namespace wayfare
