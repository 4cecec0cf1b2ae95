#include <wayfare/graph/robust_kernel.hpp>

#include <gtest/gtest.h>

namespace wayfare {
namespace {

constexpr RobustKernelKind kAllKernels[] = {
    RobustKernelKind::none, RobustKernelKind::huber, RobustKernelKind::cauchy,
    RobustKernelKind::geman_mcclure, RobustKernelKind::dynamic_covariance_scaling};

TEST(RobustKernel, WeightIsTheDerivativeOfTheCost) {
  for (const auto kind : kAllKernels) {
    for (const double scale : {0.5, 1.0, 3.0}) {
      const RobustKernel rho{kind, scale};
      for (const double s : {0.01, 0.3, 2.0, 7.0, 50.0}) {
        const double h = 1e-6 * s;
        const double slope = (rho(s + h).cost - rho(s - h).cost) / (2 * h);
        EXPECT_NEAR(rho(s).weight, slope, 1e-7) << static_cast<int>(kind) << " at " << s;
      }
    }
  }
}

TEST(RobustKernel, KeepsSmallErrorsAndNeverIncreasesAnError) {
  for (const auto kind : kAllKernels) {
    const RobustKernel rho{kind, 2.0};
    EXPECT_EQ(rho(0.0).cost, 0.0);
    EXPECT_EQ(rho(0.0).weight, 1.0);
    double weight = 1.0, cost = 0.0;
    for (double s = 0.1; s < 1e6; s *= 1.7) {
      EXPECT_GT(rho(s).weight, 0.0);
      EXPECT_LE(rho(s).weight, weight);
      EXPECT_LE(rho(s).cost, s);
      EXPECT_GE(rho(s).cost, cost);
      weight = rho(s).weight;
      cost = rho(s).cost;
    }
  }
}

TEST(RobustKernel, BoundedKernelsApproachTheirBounds) {
  EXPECT_NEAR((RobustKernel{RobustKernelKind::geman_mcclure, 2.0}(1e12).cost), 4.0, 1e-6);
  EXPECT_NEAR((RobustKernel{RobustKernelKind::dynamic_covariance_scaling, 2.0}(1e12).cost), 12.0,
              1e-6);
}

}  // namespace
}  // namespace wayfare
