#include <wayfare/core/statistics.hpp>

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

namespace wayfare::eval {
namespace {

TEST(ChiSquare, ProbabilityMatchesTheClosedForms) {
  // Two degrees: 1 − e^(−x/2). One: erf(√(x/2)). Even n: 1 − e^(−x/2) Σ_{k<n/2} (x/2)^k / k!.
  for (const double x : {1e-6, 0.01, 0.5, 1.0, 3.0, 10.0, 40.0}) {
    EXPECT_NEAR(chi_square_probability(x, 2) / -std::expm1(-x / 2), 1.0, 1e-13);
    EXPECT_NEAR(chi_square_probability(x, 1) / std::erf(std::sqrt(x / 2)), 1.0, 1e-13);
    double sum = 0, term = 1;
    for (int k = 0; k < 12; ++k) sum += term, term *= x / 2 / (k + 1);
    EXPECT_NEAR(chi_square_probability(x, 24), 1 - std::exp(-x / 2) * sum, 1e-14);
  }
  EXPECT_EQ(chi_square_probability(0, 3), 0.0);
  EXPECT_EQ(chi_square_probability(-1, 3), 0.0);
  EXPECT_TRUE(std::isnan(chi_square_probability(NAN, 3)));
}

TEST(ChiSquare, QuantilesMatchThePublishedTable) {
  // Two degrees in closed form; the rest from Abramowitz and Stegun 1964, table 26.8.
  for (const double p : {0.001, 0.025, 0.5, 0.975, 0.999999})
    EXPECT_NEAR(chi_square_quantile(p, 2) / (-2 * std::log1p(-p)), 1.0, 1e-10);
  EXPECT_NEAR(chi_square_quantile(0.95, 1), 3.84146, 5e-6);
  EXPECT_NEAR(chi_square_quantile(0.005, 10), 2.15586, 5e-6);
  EXPECT_NEAR(chi_square_quantile(0.95, 30), 43.7730, 5e-5);
  EXPECT_NEAR(chi_square_quantile(0.025, 100), 74.2219, 5e-5);
  EXPECT_NEAR(chi_square_quantile(0.975, 100), 129.561, 5e-4);
  EXPECT_EQ(chi_square_quantile(0, 5), 0.0);
}

TEST(ChiSquare, QuantileInvertsTheProbabilityForManyDegrees) {
  for (const double dof : {0.5, 7.0, 2300.0, 1e5})
    for (const double p : {1e-6, 0.025, 0.5, 0.975, 1 - 1e-6})
      EXPECT_NEAR(chi_square_probability(chi_square_quantile(p, dof), dof), p, 1e-11);
}

// Two more degrees of freedom: F(x, n + 2) = F(x, n) − (x/2)^(n/2) e^(−x/2) / Γ(n/2 + 1) (26.4.8).
TEST(ChiSquare, SatisfiesTheRecurrenceAcrossTheChangeOfExpansion) {
  for (double dof = 0.5; dof < 400.0; dof *= 1.7) {
    for (const double part : {0.2, 0.9, 1.0, 1.1, 1.5, 3.0}) {
      const double x = part * dof, a = 0.5 * dof;
      const double step = std::exp(a * std::log(0.5 * x) - 0.5 * x - std::lgamma(a + 1.0));
      EXPECT_NEAR(chi_square_probability(x, dof) - chi_square_probability(x, dof + 2.0), step,
                  1e-12);
    }
  }
}

TEST(ChiSquare, LimitsOfTheRange) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  EXPECT_EQ(chi_square_probability(1e6, 3.0), 1.0);
  EXPECT_EQ(chi_square_probability(kInfinity, 3.0), 1.0);
  // √(2/π)·√x = p for one degree of freedom: x is below the smallest number here.
  EXPECT_LE(chi_square_quantile(1e-200, 1.0), std::numeric_limits<double>::min());
}

}  // namespace
}  // namespace wayfare::eval
