#include <wayfare/core/detail/stumpff.hpp>

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

namespace wayfare {
namespace {

/// The series in extended precision; 60 terms are enough for x up to 100.
template <int N>
long double by_series(long double x) {
  long double term = 1.0L;
  for (int i = 2; i <= N; ++i) term /= i;
  long double sum = 0.0L;
  for (int k = 1; k <= 60; ++k) {
    sum += term;
    term *= -x / static_cast<long double>((N + 2 * k - 1) * (N + 2 * k));
  }
  return sum;
}

template <int N, class T>
void expect_series() {
  constexpr T kEpsilon = std::numeric_limits<T>::epsilon();
  // From far below the change of formula at 0.25 to three half turns.
  for (double x = 1e-12; x < 25.0; x *= 1.07) {
    const T rounded = static_cast<T>(x);
    const auto want = static_cast<double>(by_series<N>(static_cast<long double>(rounded)));
    // Above 0.25 each division by x loses at most two bits of 1/(N − 2)!.
    const double tolerance = 64.0 * static_cast<double>(kEpsilon) / detail::factorial(N % 2);
    EXPECT_NEAR(static_cast<double>(stumpff<N>(rounded)), want, tolerance) << "x = " << x;
  }
}

TEST(Stumpff, MatchesItsSeries) {
  expect_series<0, double>();
  expect_series<1, double>();
  expect_series<2, double>();
  expect_series<3, double>();
  expect_series<4, double>();
  expect_series<5, double>();
  expect_series<2, float>();
  expect_series<3, float>();
}

TEST(Stumpff, MatchesTheQuotientsOfSineAndCosine) {
  for (double angle = 0.6; angle < 3.2; angle += 0.1) {
    const double x = angle * angle;
    EXPECT_NEAR(stumpff<0>(x), std::cos(angle), 1e-15);
    EXPECT_NEAR(stumpff<1>(x), std::sin(angle) / angle, 1e-15);
    EXPECT_NEAR(stumpff<2>(x), (1.0 - std::cos(angle)) / x, 1e-15);
    EXPECT_NEAR(stumpff<3>(x), (angle - std::sin(angle)) / (x * angle), 1e-15);
  }
}

// The quotients cancel at small arguments: relative errors, down to zero.
TEST(Stumpff, KeepsEveryDigitNearZero) {
  for (const double x : {0.0, 1e-300, 1e-30, 1e-10, 1e-4, 0.01, 0.24999999}) {
    EXPECT_NEAR(stumpff<2>(x) / static_cast<double>(by_series<2>(x)), 1.0, 4e-16);
    EXPECT_NEAR(stumpff<3>(x) / static_cast<double>(by_series<3>(x)), 1.0, 4e-16);
    const auto single = static_cast<float>(x);
    EXPECT_NEAR(stumpff<3>(single) / static_cast<double>(by_series<3>(single)), 1.0, 2e-7);
  }
}

TEST(Stumpff, LanesOnBothSidesOfTheChangeOfFormula) {
  Pack<double, 4> x(0.0);
  const double lanes[] = {0.0, 0.2, 0.3, 9.0};
  for (int i = 0; i < 4; ++i) x.set(i, lanes[i]);
  const auto c3 = stumpff<3>(x);
  for (int i = 0; i < 4; ++i) EXPECT_NEAR(c3[i], stumpff<3>(lanes[i]), 1e-16) << "lane " << i;
}

}  // namespace
}  // namespace wayfare
