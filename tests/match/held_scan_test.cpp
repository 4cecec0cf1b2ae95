// Whether a map constrains a scan along a direction that its normals leave unconstrained.

#include <cmath>

#include <gtest/gtest.h>

#include <wayfare/map/probability_grid.hpp>
#include <wayfare/match/detail/scene_constraint.hpp>
#include <wayfare/match/gauss_newton.hpp>

#include "walls.hpp"

namespace wayfare {
namespace {

/// Displacement cost of a scan in a map of scans a quarter of a metre apart.
SceneConstraint constraint_amid(const Walls& walls) {
  Rng rng(35);
  MultiResolutionGrid map;
  for (int i = -12; i <= 12; ++i) {
    const SE2d place(0.25 * i, 0.0, Angle());
    EXPECT_TRUE(map.insert(place, walls.scan(place, rng)));
  }
  const auto match =
      GaussNewtonMatcher().match(map.tables(), end_points(walls.scan(SE2d(), rng)), SE2d(),
                                 {0.5, 0.5, Angle::degrees(20)}, {.covariance = true});
  EXPECT_TRUE(match && *match && (*match)->constraint);
  return match && *match ? (*match)->constraint.value_or(SceneConstraint{}) : SceneConstraint{};
}

TEST(HeldScan, SlidesAlongABareCorridor) {
  const SceneConstraint bare = constraint_amid(Walls::corridor(Angle()));
  EXPECT_GT(std::abs(bare.weakest.x()), 0.95);
  EXPECT_LT(bare.displacement_cost_nats, 1.0);
}

// Normals over 0.6 m hardly resolve niches of 0.3 m. Displaced by a quarter of a metre, the points
// in them fall into cells observed as free, which changes each residual by about one: ten of a
// hundred points cost 0.5 · 20 · 0.1 / 0.4² = 6 nats.
TEST(HeldScan, IsConstrainedByNiches) {
  Walls niches;
  for (const double side : {-1.0, 1.0})
    for (double x = -20; x < 20; x += 2.5) {
      const double in = 1.2 * side, out = 1.35 * side;
      niches.walls.push_back({{x, in}, {x + 2.2, in}});
      niches.walls.push_back({{x + 2.2, in}, {x + 2.2, out}});
      niches.walls.push_back({{x + 2.2, out}, {x + 2.5, out}});
      niches.walls.push_back({{x + 2.5, out}, {x + 2.5, in}});
    }
  EXPECT_GT(constraint_amid(niches).displacement_cost_nats, 2.5);
}

TEST(HeldScan, IsNotConstrainedByUnobservedCells) {
  Rng rng(36);
  MultiResolutionGrid map;
  const Walls room = Walls::room();
  ASSERT_TRUE(map.insert(SE2d(), room.scan(SE2d(), rng)));
  const SE2d outside(30, 30, Angle());
  const auto match = GaussNewtonMatcher({.max_iterations = 0})
                         .match(map.tables(), end_points(room.scan(SE2d(), rng)), outside,
                                {0.5, 0.5, Angle::degrees(20)}, {.covariance = true});
  ASSERT_TRUE(match && *match && (*match)->constraint);
  EXPECT_EQ((*match)->constraint->displacement_cost_nats, 0.0);
  // Every residual is r = 1 − p of an unobserved cell, with the default σ of 0.4; no point is on a
  // wall, so that only the window bounds the pose.
  const double r = 1.0 - static_cast<double>(map.tables().back().unknown()) / ProbabilityGrid::kOne;
  EXPECT_NEAR((*match)->score, 1.0 - r, 1e-6);
  EXPECT_NEAR((*match)->mean_log_likelihood, -r * r / (2.0 * 0.4 * 0.4), 1e-5);
  EXPECT_EQ((*match)->constraint->share, 0.0);
  const double turn = Angle::degrees(20).radians();
  const Eigen::Matrix3d want = Eigen::Vector3d(0.25, 0.25, turn * turn).asDiagonal();
  EXPECT_LT((*(*match)->covariance - want).norm(), 1e-9);
}

}  // namespace
}  // namespace wayfare
