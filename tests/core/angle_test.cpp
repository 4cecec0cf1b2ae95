#include <wayfare/core/angle.hpp>

#include <cmath>
#include <limits>
#include <numbers>

#include <gtest/gtest.h>

#include <wayfare/core/detail/bare_number.hpp>
#include <wayfare/core/dual.hpp>

namespace wayfare {
namespace {

using std::numbers::pi;

// Types that a type with a unit cannot be constructed from (messages: compile_fail/).
static_assert(BareNumber<double> && BareNumber<float> && BareNumber<int>);
static_assert(!BareNumber<Angle> && !BareNumber<const char*>);

TEST(Angle, UnitsAndArithmetic) {
  EXPECT_DOUBLE_EQ((180_deg).radians(), pi);
  EXPECT_DOUBLE_EQ((0.5_rad).degrees(), 90.0 / pi);
  EXPECT_DOUBLE_EQ((30_deg + 60_deg - 2.0 * 15_deg).degrees(), 60.0);
  EXPECT_DOUBLE_EQ(90_deg / 30_deg, 3.0);
  EXPECT_DOUBLE_EQ((90_deg / 3.0).degrees(), 30.0);
  Angle a = 10_deg;
  a += 25_deg;
  EXPECT_DOUBLE_EQ(a.degrees(), 35.0);
  a -= 40_deg;
  EXPECT_NEAR(a.degrees(), -5.0, 1e-13);
  EXPECT_LT(-1_deg, 0_deg);
  EXPECT_EQ((1_rad).radians(), 1.0);
}

TEST(Angle, WrapKeepsTheHalfOpenCircle) {
  for (const double x : {0.0, 1.0, -1.0, pi, std::nextafter(-pi, 0.0), 1e-300, -1e-300}) {
    EXPECT_EQ(wrap_to_pi(x), x);
  }
}

// With ulp(π) = 2⁻⁵¹ the doubles next to ±π and ±3π are known exactly; −π itself is the excluded
// end. 3 * pi rounds to a multiple of 2⁻⁵⁰ (here down by 2⁻⁵¹, as 2π − 3π shows exactly).
TEST(Angle, WrapClosedFormAtTheEnds) {
  EXPECT_EQ(wrap_to_pi(-pi), pi);
  EXPECT_EQ(wrap_to_pi(std::nextafter(pi, 4.0)), -pi + 0x1p-51);
  EXPECT_EQ(wrap_to_pi(std::nextafter(-pi, -4.0)), pi - 0x1p-51);
  EXPECT_EQ(wrap_to_pi(2 * pi), 0.0);
  EXPECT_EQ(wrap_to_pi(-2 * pi), 0.0);
  EXPECT_EQ(wrap_to_pi(1.5 * pi), -0.5 * pi);
  EXPECT_EQ(wrap_to_pi(-1.5 * pi), 0.5 * pi);
  EXPECT_EQ(wrap_to_pi(256 * pi), 0.0);
}

// Wrapping subtracts k times the double 2π, which is off by 2.45e-16; the direction changes by at
// most k times that, well below the spacing of the doubles near the argument.
TEST(Angle, WrapOfHugeValues) {
  for (double x = 3.0; x < 1e15; x *= 7.7) {
    for (const double value : {x, -x}) {
      const double wrapped = wrap_to_pi(value);
      ASSERT_GT(wrapped, -pi);
      ASSERT_LE(wrapped, pi);
      const double allowed = x / (2 * pi) * 2.45e-16 + 1e-15;
      EXPECT_NEAR(std::sin(wrapped), std::sin(value), allowed) << value;
      EXPECT_NEAR(std::cos(wrapped), std::cos(value), allowed) << value;
    }
  }
}

TEST(Angle, WrapStaysInRangeAroundEveryOddMultiple) {
  for (int k = -9999; k <= 9999; k += 2) {
    double x = k * pi;
    for (int step = 0; step < 4; ++step) x = std::nextafter(x, -1e9);
    for (int step = 0; step < 8; ++step, x = std::nextafter(x, 1e9)) {
      ASSERT_GT(wrap_to_pi(x), -pi) << k;
      ASSERT_LE(wrap_to_pi(x), pi) << k;
      const auto single = static_cast<float>(x);
      ASSERT_GT(wrap_to_pi(single), -std::numbers::pi_v<float>) << k;
      ASSERT_LE(wrap_to_pi(single), std::numbers::pi_v<float>) << k;
    }
  }
}

TEST(Angle, WrapOfNonFiniteIsNaN) {
  EXPECT_TRUE(std::isnan(wrap_to_pi(std::numeric_limits<double>::infinity())));
  EXPECT_TRUE(std::isnan(wrap_to_pi(-std::numeric_limits<double>::infinity())));
  EXPECT_TRUE(std::isnan(wrap_to_pi(std::numeric_limits<double>::quiet_NaN())));
}

TEST(Angle, WrapKeepsTheDerivative) {
  using Number = Dual<double, 1>;
  for (const double x : {4.0, -4.0, 10.0, -0.5, 2.0 * pi}) {
    const Number wrapped = wrap_to_pi(Number::variable(x, 0));
    EXPECT_NEAR(wrapped.value, std::remainder(x, 2.0 * pi), 1e-14) << x;
    EXPECT_EQ(wrapped.derivatives[0], 1.0) << x;
  }
}

TEST(Angle, WrappedKeepsTheType) {
  EXPECT_NEAR((350_deg).wrapped().degrees(), -10.0, 1e-13);
  EXPECT_NEAR((170_deg - -170_deg).wrapped().degrees(), -20.0, 1e-13);
}

}  // namespace
}  // namespace wayfare
