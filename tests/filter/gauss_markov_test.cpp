#include <wayfare/filter/gauss_markov.hpp>

#include <cmath>

#include <gtest/gtest.h>

namespace wayfare {
namespace {

TEST(GaussMarkov, MatchesTheExponential) {
  for (const double x : {1e-9, 1e-4, 0.029, 0.031, 0.5, 20.0}) {
    const auto s = discretise_gauss_markov(3.0, 10.0, 10.0 * x);
    EXPECT_NEAR(s.phi, std::exp(-x), 1e-15);
    EXPECT_NEAR(s.q, 9.0 * -std::expm1(-2.0 * x), 1e-14 * s.q) << x;
  }
}

// Two steps are one of double length, and the stationary variance stays: exact discretisation.
TEST(GaussMarkov, StepsCompose) {
  const auto one = discretise_gauss_markov(0.2, 40.0, 0.7),
             two = discretise_gauss_markov(0.2, 40.0, 1.4);
  EXPECT_NEAR(one.phi * one.phi, two.phi, 1e-15);
  EXPECT_NEAR(one.phi * one.phi * one.q + one.q, two.q, 1e-16);
  EXPECT_NEAR(one.phi * one.phi * 0.04 + one.q, 0.04, 1e-16);
}

TEST(ReceiverClock, StepsCompose) {
  const auto one = discretise_clock(0.3, 0.1, 0.5), two = discretise_clock(0.3, 0.1, 1.0);
  // Φ Q Φᵀ + Q with Φ = [1 dt; 0 1].
  EXPECT_NEAR(
      one.bias_variance + 2 * 0.5 * one.covariance + 0.25 * one.drift_variance + one.bias_variance,
      two.bias_variance, 1e-15);
  EXPECT_NEAR(2 * one.covariance + 0.5 * one.drift_variance, two.covariance, 1e-15);
  EXPECT_NEAR(2 * one.drift_variance, two.drift_variance, 1e-15);
}

}  // namespace
}  // namespace wayfare
