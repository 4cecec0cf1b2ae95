#pragma once

// The laws of a robust kernel, as checks on any type:
//
//   KernelLaws<MyKernel>{MyKernel{2.0}}.check();

#include <cmath>

#include <gtest/gtest.h>

#include <wayfare/graph/robust_kernel.hpp>

namespace wayfare::testing {

/// Fails the current test where ρ(s), s the squared error in standard deviations, breaks its laws.
template <KernelFunction K>
struct KernelLaws {
  K kernel;                 ///< under test
  double largest = 1e6;     ///< s up to which the laws are checked
  double tolerance = 1e-7;  ///< of ρ′

  /// All laws.
  void check() const {
    small_errors_are_kept();
    grows_more_and_more_slowly();
    weight_is_the_slope();
  }

  /// ρ(0) = 0, ρ′(0) = 1.
  void small_errors_are_kept() const {
    const KernelValue zero = kernel(0.0);
    EXPECT_EQ(zero.cost, 0.0) << "rho(0)";
    EXPECT_EQ(zero.weight, 1.0) << "rho'(0)";
  }

  /// 0 ≤ ρ′ ≤ 1, ρ′ does not increase, ρ does not decrease and is at most s. Both are finite.
  void grows_more_and_more_slowly() const {
    KernelValue last = kernel(0.0);
    for (double s = 1e-6; s <= largest; s *= 1.1) {
      const KernelValue now = kernel(s);
      const double rounding = 1e-12 * (1.0 + s);
      EXPECT_TRUE(std::isfinite(now.cost) && std::isfinite(now.weight)) << "not finite at " << s;
      EXPECT_GE(now.weight, 0.0) << "rho' at " << s;
      EXPECT_LE(now.weight, last.weight + 1e-12) << "rho' increases at " << s;
      EXPECT_GE(now.cost, last.cost - rounding) << "rho decreases at " << s;
      EXPECT_LE(now.cost, s + rounding) << "rho at " << s;
      last = now;
    }
  }

  /// (ρ(s + h) − ρ(s − h)) / 2h is the mean of ρ′ between s − h and s + h, which does not increase.
  void weight_is_the_slope() const {
    for (double s = 0.01; s <= largest; s *= 1.3) {
      const double h = 1e-6 * s;
      const KernelValue before = kernel(s - h), after = kernel(s + h);
      const double slope = (after.cost - before.cost) / (2.0 * h);
      EXPECT_GE(slope, after.weight - tolerance) << "slope of rho at " << s;
      EXPECT_LE(slope, before.weight + tolerance) << "slope of rho at " << s;
    }
  }
};

}  // namespace wayfare::testing
