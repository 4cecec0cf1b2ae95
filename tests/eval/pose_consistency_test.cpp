#include <wayfare/eval/pose_consistency.hpp>

#include <cmath>
#include <utility>

#include <gtest/gtest.h>

#include <wayfare/core/random.hpp>

#include "core/at.hpp"

namespace wayfare::eval {
namespace {

using tests::at;

/// Along a circle of radius 2 m.
Trajectory circle() {
  Trajectory truth;
  for (int i = 0; i <= 100; ++i)
    truth.push_back({at(i), Transform2<frame::Map, frame::Base>(
                                SE2d(3.0, -1.0, Angle::degrees(30)) *
                                SE2d::exp(Eigen::Vector3d(0.2 * i, 0, 0.1 * i)))});
  return truth;
}

// A displacement of 0.2 m forwards and a rotation of 0.1 rad, with σ of 0.1 m and 0.05 rad:
// 2² + 2² = 8. The estimate is in another frame than the truth, which does not count.
TEST(PoseConsistency, IsOfThePoseRelativeToTheFirst) {
  PoseConsistency c(circle());
  const SE2d frame(-7.0, 2.0, Angle::degrees(100));
  const Eigen::Matrix3d p = Eigen::Vector3d(0.01, 0.01, 0.0025).asDiagonal();
  const auto estimate = [&](double s, const Eigen::Vector3d& error) {
    return frame * pose_at(circle(), at(s))->plus(error);
  };
  EXPECT_TRUE(c.add(at(0), estimate(0, Eigen::Vector3d::Zero()), Eigen::Matrix3d::Zero()));
  EXPECT_EQ(c.count(), 0U);
  EXPECT_TRUE(std::isnan(c.mean_nees()));
  EXPECT_TRUE(c.add(at(10.5), estimate(10.5, {-0.2, 0, 0.1}), p));
  EXPECT_NEAR(c.mean_nees(), 8.0, 1e-9);
  EXPECT_NEAR(c.error_m(), 0.2, 1e-9);
  EXPECT_NEAR(c.error_rad(), 0.1, 1e-9);
  EXPECT_NEAR(c.sigma_m(), std::sqrt(0.02), 1e-12);
  EXPECT_NEAR(c.sigma_rad(), 0.05, 1e-12);
  EXPECT_TRUE(c.add(at(20), estimate(20, {0, 0, 0}), p));
  EXPECT_NEAR(c.mean_nees(), 4.0, 1e-9);
  EXPECT_NEAR(c.largest_nees(), 8.0, 1e-9);
  EXPECT_NEAR(c.error_m(), 0.2 / std::sqrt(2.0), 1e-9);
  EXPECT_FALSE(c.add(at(101), SE2d(), p));  // after the truth
  EXPECT_EQ(c.count(), 2U);
  EXPECT_TRUE(c.add(at(30), estimate(30, {0, 0, 0}), -p));
  EXPECT_TRUE(std::isnan(c.mean_nees()));
  EXPECT_TRUE(c.add(at(40), estimate(40, {0, 0, 0}), p));
  EXPECT_NEAR(c.largest_nees(), 8.0, 1e-9);
}

// Errors drawn from the covariance, one pose a drive: independent samples.
TEST(PoseConsistency, IsThreeForErrorsOfTheCovariance) {
  Rng rng(5);
  IndependentMean nees;
  const Eigen::Vector3d sigma(0.1, 0.3, 0.02);
  const Trajectory truth = circle();
  for (int drive = 0; drive < 2000; ++drive) {
    PoseConsistency c(truth);
    c.add(at(0), truth.front().T_map_base.raw(), Eigen::Matrix3d::Zero());
    const Eigen::Vector3d error =
        sigma.cwiseProduct(Eigen::Vector3d(rng.normal(), rng.normal(), rng.normal()));
    c.add(at(50), truth[50].T_map_base.raw().plus(error), sigma.cwiseAbs2().asDiagonal());
    nees.add(c.mean_nees());
  }
  EXPECT_TRUE(mean_nees_bounds(3, 2000, 0.999).contains(nees.mean())) << nees.mean();
}

}  // namespace
}  // namespace wayfare::eval
