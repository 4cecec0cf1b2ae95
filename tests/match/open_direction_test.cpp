// How far a scene constrains a match, and what is done along the direction that it leaves open.

#include "match/open_direction.hpp"

#include <cmath>
#include <utility>

#include <gtest/gtest.h>

namespace wayfare {
namespace {

// Σ g gᵀ = diag(30, 10, 80) with ρ = 2 m: the shares of 30 + 10 are 3/4, 1/4 and 80/4/40 = 1/2; of
// diag(30, 10, 16) the last is 16/4/40 = 1/10.
TEST(SceneConstraint, TheShareIsThatOfTheWeakestDirection) {
  const auto walls = SceneConstraint::of(Eigen::Vector3d(30, 10, 80).asDiagonal(), 2.0);
  EXPECT_NEAR(walls.share, 0.25, 1e-15);
  EXPECT_NEAR(std::abs(walls.weakest.y()), 1.0, 1e-15);
  const auto round = SceneConstraint::of(Eigen::Vector3d(30, 10, 16).asDiagonal(), 2.0);
  EXPECT_NEAR(round.share, 0.1, 1e-15);
  EXPECT_NEAR(std::abs(round.weakest.z()), 1.0, 1e-15);
  EXPECT_EQ(SceneConstraint::of(Eigen::Matrix3d::Zero(), 2.0).share, 0.0);
  EXPECT_EQ(SceneConstraint::of(Eigen::Matrix3d::Identity(), 0.0).share, 0.0);
  EXPECT_FALSE(SceneConstraint{.share = 0.0199}.complete());
  EXPECT_TRUE(SceneConstraint{.share = 0.02}.complete());
}

// Open up to a share of 0.001 and a cost of 1 nat, constrained from 0.004 or 2.5 nats on, linear
// between.
TEST(OpenDirection, IsOpenByShareAndCost) {
  struct {
    double share, nats, openness;
  } const rows[] = {{0.001, 1.0, 1.0},        {0.0025, 0.0, 0.5}, {0.0, 1.75, 0.5},
                    {0.0025, 1.75, 0.25},     {0.004, 0.0, 0.0},  {0.0, 2.5, 0.0},
                    {0.00175, 1.375, 0.5625}, {0.01, 0.0, 0.0},   {0.0, 9.0, 0.0}};
  for (const auto& [share, nats, openness] : rows) {
    const SceneConstraint scene{Eigen::Vector3d::UnitX(), share, nats};
    EXPECT_NEAR(OpenDirection(scene, 1.0).openness(), openness, 1e-12) << share << ", " << nats;
  }
}

// Along (y, ρθ) = (0.6, 0.8) with ρ = 2 m: a gap of 0.5 m in y and 0.1 rad has the part 0.3 + 0.16
// m along it: 0.6 of that in y, 0.8/2 rad/m in heading. Half open: half of the way, half of the
// variance.
TEST(OpenDirection, TheExpectedPoseHoldsAlongIt) {
  for (const auto& [share, openness] : {std::pair{0.0, 1.0}, {0.0025, 0.5}}) {
    const OpenDirection open(SceneConstraint{Eigen::Vector3d(0, 0.6, 0.8), share, 0.0}, 2.0);
    const SE2d matched(3.0, -1.0, Angle::degrees(40));
    const SE2d settled = open.settle(matched, matched.plus({0.2, 0.5, 0.1}));
    const double part = openness * 0.46;
    // The gap of x is across: it remains.
    EXPECT_LT((settled.minus(matched) - part * Eigen::Vector3d(0, 0.6, 0.4)).norm(), 1e-12);
    const Eigen::Vector3d u(0, 0.6, 0.4);
    const Eigen::Matrix3d narrow = Eigen::Vector3d(1, 2, 3).asDiagonal();
    EXPECT_LT((open.widen(narrow, 0.5) - narrow - 0.25 * openness * u * u.transpose()).norm(),
              1e-12);
    EXPECT_LT((open.widen(narrow) - narrow - openness * u * u.transpose()).norm(), 1e-12);
  }
}

// Points nearer than 0.1 m on average count as that far away.
TEST(OpenDirection, TheLeverIsTenCentimetresAtLeast) {
  const OpenDirection open(SceneConstraint{Eigen::Vector3d::UnitZ()}, 0.01);
  EXPECT_NEAR(open.widen(Eigen::Matrix3d::Zero(), 0.5)(2, 2), 25.0, 1e-12);
}

}  // namespace
}  // namespace wayfare
