#include <wayfare/graph/robust_kernel.hpp>

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <wayfare/testing/kernel_laws.hpp>
#include "core/faults_of.hpp"

namespace wayfare {
namespace {

using testing::KernelLaws;

constexpr RobustKernelKind kAllKernels[] = {
    RobustKernelKind::none, RobustKernelKind::huber, RobustKernelKind::cauchy,
    RobustKernelKind::geman_mcclure, RobustKernelKind::dynamic_covariance_scaling};

TEST(RobustKernel, IsAKernel) {
  for (const auto kind : kAllKernels) {
    for (const double scale : {0.5, 1.0, 2.0, 3.0}) {
      SCOPED_TRACE(::testing::Message() << static_cast<int>(kind) << " of scale " << scale);
      const RobustKernel rho{kind, scale};
      KernelLaws<RobustKernel>{rho}.check();
      for (double s = 0.1; s < 1e6; s *= 1.7) EXPECT_GT(rho(s).weight, 0.0);
    }
  }
}

/// Cost and weight of Huber's kernel, one of them wrong.
struct Faulty {
  double offset = 0.0, cost = 1.0, weight = 1.0, largest = 1e300;
  KernelValue operator()(double s) const {
    const KernelValue huber = RobustKernel{RobustKernelKind::huber, 2.0}(s);
    if (s > largest) return {NAN, huber.weight};
    return {offset + cost * huber.cost, s > 0.0 ? weight * huber.weight : 1.0};
  }
};

TEST(KernelLaws, NameWhatIsWrong) {
  const auto faults = [](const Faulty& kernel) {
    return testing::faults_of([&] { KernelLaws<Faulty>{kernel}.check(); });
  };
  using ::testing::HasSubstr;
  EXPECT_EQ(faults({}), "");
  EXPECT_THAT(faults({.offset = -1e-3}), HasSubstr("rho(0)"));
  EXPECT_THAT(faults({.cost = 1.1}), HasSubstr("rho at"));
  EXPECT_THAT(faults({.weight = 0.99}), HasSubstr("slope of rho"));
  EXPECT_THAT(faults({.weight = 1.1}), HasSubstr("rho' increases"));
  EXPECT_THAT(faults({.largest = 1e3}), HasSubstr("not finite"));
}

TEST(RobustKernel, BoundedKernelsApproachTheirBounds) {
  EXPECT_NEAR((RobustKernel{RobustKernelKind::geman_mcclure, 2.0}(1e12).cost), 4.0, 1e-6);
  EXPECT_NEAR((RobustKernel{RobustKernelKind::dynamic_covariance_scaling, 2.0}(1e12).cost), 12.0,
              1e-6);
}

}  // namespace
}  // namespace wayfare
