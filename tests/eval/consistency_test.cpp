#include <wayfare/eval/consistency.hpp>

#include <cmath>

#include <gtest/gtest.h>
#include <Eigen/LU>

#include <wayfare/core/random.hpp>

namespace wayfare::eval {
namespace {

TEST(NormalisedSquared, IsTheMahalanobisDistanceInAnyUnits) {
  const Eigen::Matrix3d p = (Eigen::Matrix3d() << 4, 1, 0.5, 1, 3, -0.2, 0.5, -0.2, 2).finished();
  const Eigen::Vector3d e(1, -2, 0.5);
  const double expected = e.dot(p.inverse() * e);
  EXPECT_NEAR(normalised_squared(e, p), expected, 1e-12);
  const Eigen::DiagonalMatrix<double, 3> unit(1e3, 1e-9, 1.0);
  const Eigen::Matrix3d other = unit * p * unit;
  EXPECT_NEAR(normalised_squared((unit * e).eval(), other), expected, 1e-12);
  EXPECT_TRUE(std::isnan(normalised_squared(e, Eigen::Matrix3d(-p))));
}

// Runs of independent values, as assumed by the bounds.
NeesOverRuns draw(double inflation, int dof, std::size_t epochs, int runs) {
  NeesOverRuns nees(dof, epochs);
  Rng rng(3);
  for (int r = 0; r < runs; ++r) {
    for (std::size_t k = 0; k < epochs; ++k) {
      double sum = 0;
      for (int i = 0; i < dof; ++i) sum += inflation * std::pow(rng.normal(), 2);
      nees.add(k, sum);
    }
  }
  return nees;
}

TEST(NeesOverRuns, ConsistentErrorsAreWithinTheBoundsAtTheirRate) {
  const NeesOverRuns nees = draw(1.0, 23, 2000, 50);
  // Binomial standard deviation over 2000 epochs: 0.005.
  EXPECT_NEAR(nees.share_within(0.95), 0.95, 0.02);
  EXPECT_NEAR(nees.share_within(0.5), 0.5, 0.05);
  EXPECT_NEAR(nees.mean_of_all(), 23.0, 5 * std::sqrt(2.0 * 23 / (2000 * 50)));
}

TEST(NeesOverRuns, DetectsTenPercentOverconfidence) {
  EXPECT_LT(draw(1.1, 23, 500, 100).share_within(0.95), 0.3);
  EXPECT_LT(draw(0.9, 23, 500, 100).share_within(0.95), 0.3);
}

TEST(NeesOverRuns, NonFiniteValuesAreOutside) {
  NeesOverRuns nees(3, 2);
  nees.add(0, NAN);
  nees.add(0, 3.0);
  EXPECT_EQ(nees.share_within(), 0.0);  // epoch 1 has no values
  EXPECT_TRUE(std::isinf(nees.mean(0)));
}

TEST(NeesOverRuns, SumsCountAsTheirValues) {
  NeesOverRuns one(1, 1), other(1, 1);
  for (const double x : {0.5, 2.0, 0.1}) one.add(0, x);
  other.add(0, 2.6, 3);
  EXPECT_DOUBLE_EQ(one.mean(0), other.mean(0));
  EXPECT_EQ(other.count(), 3U);
}

TEST(IndependentMean, HasTheDeviationOfItsValues) {
  IndependentMean mean;
  for (const double x : {1.0, 2.0, 4.0, 5.0}) mean.add(x);
  EXPECT_DOUBLE_EQ(mean.mean(), 3.0);
  EXPECT_DOUBLE_EQ(mean.deviation(), std::sqrt(10.0 / 3.0));
  EXPECT_DOUBLE_EQ(mean.standard_error(), std::sqrt(10.0 / 12.0));
}

TEST(SigmaCount, SharesOfNormalErrorsAreTheirIntegrals) {
  SigmaCount<2> count;
  Rng rng(1);
  for (int i = 0; i < 100000; ++i) {
    const double a = rng.normal(), b = 3 * rng.normal();
    count.add({a, b}, {1.0, 3.0});
  }
  const double expected[] = {0.6827, 0.9545, 0.9973};
  for (int k = 1; k <= 3; ++k)
    for (int i = 0; i < 2; ++i) EXPECT_NEAR(count.share(k)[i], expected[k - 1], 0.008);
  EXPECT_EQ(count.count(), 100000U);
}

}  // namespace
}  // namespace wayfare::eval
