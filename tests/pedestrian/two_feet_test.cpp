// Two feet on simulated walks with a bound on their distance.
#include <wayfare/pedestrian/two_feet.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include <wayfare/core/statistics.hpp>
#include <wayfare/sim/vehicle_trajectory.hpp>
#include <wayfare/sim/walks.hpp>

namespace wayfare {
namespace {

using Side = TwoFeet::Side;

struct Ends {
  double left_m = 0.0, right_m = 0.0, middle_m = 0.0, apart_m = 0.0;
  std::uint64_t projections = 0;
};

TwoFeet walked(const sim::FeetTruth& truth, const TwoFeetParameters& p) {
  TwoFeet feet(p);
  const auto none = [](Side, const FootPose&) {};
  for (std::size_t i = 0; i < truth.left.samples.size(); ++i) {
    feet.add(Side::left, truth.left.samples[i], none);
    feet.add(Side::right, truth.right.samples[i], none);
  }
  feet.finish(none);
  return feet;
}

Ends walk(const sim::FeetTruth& truth, const TwoFeetParameters& p) {
  const TwoFeet feet = walked(truth, p);
  const Eigen::Vector3d l = feet.position(Side::left), r = feet.position(Side::right);
  const Eigen::Vector3d lt = truth.left.position.back();
  const Eigen::Vector3d rt = truth.right_from_left + truth.right.position.back();
  const auto level = [](const Eigen::Vector3d& v) { return v.head<2>().norm(); };
  return {level(l - lt), level(r - rt), level(0.5 * (l + r) - 0.5 * (lt + rt)), (l - r).norm(),
          feet.projections()};
}

double root_mean_square(const std::vector<double>& x) { return summarise(x).rmse; }

// Integrating the simulated readings without a filter reproduces the path; the feet are never
// further apart than half a stride and their width.
TEST(SimulatedFeet, ReadingsReproduceThePath) {
  sim::FeetPlan plan;
  plan.strides = 12;
  plan.turn_rad = 0.2;
  plan.sway_radps = 0.0;  // level at the start
  const auto truth = sim::simulate_feet(plan, sim::perfect_imu(), Rng(1));
  ASSERT_EQ(truth.left.samples.size(), truth.right.samples.size());
  for (const sim::FootTruth* foot : {&truth.left, &truth.right}) {
    SO3d q;
    Eigen::Vector3d p = Eigen::Vector3d::Zero(), v = p;
    const double dt = 1.0 / plan.rate_hz;
    for (const ImuSample& s : foot->samples) {
      const Eigen::Vector3d turn = s.angular_rate_radps * dt;
      const Eigen::Vector3d a =
          q * SO3d::exp(0.5 * turn) * s.specific_force_mps2 - Eigen::Vector3d(0.0, 0.0, 9.80665);
      q = q * SO3d::exp(turn);
      p += v * dt + 0.5 * a * dt * dt;
      v += a * dt;
    }
    EXPECT_LT((p - foot->position.back()).norm(), 0.02);
    EXPECT_LT(v.norm(), 0.01);
  }
  double farthest = 0.0;
  for (std::size_t i = 0; i < truth.left.position.size(); ++i)
    farthest =
        std::max(farthest,
                 (truth.right_from_left + truth.right.position[i] - truth.left.position[i]).norm());
  EXPECT_LT(farthest, 0.5 * plan.stride_m + plan.width_m + plan.lift_m);
  EXPECT_GT(farthest, 0.5 * plan.stride_m);
}

// On a straight path the heading drift of each foot is an independent cross-track error: the
// midpoint has a smaller error than one foot, and the bound limits that of the worse foot.
TEST(TwoFeet, TheBoundCorrectsTheWorseFoot) {
  sim::FeetPlan plan;
  plan.strides = 150;
  std::vector<double> one, free, bound, worst_free, worst_bound;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const auto truth = sim::simulate_feet(plan, {}, Rng(seed));
    TwoFeetParameters p;
    p.farthest_m = 0.0;
    const Ends apart = walk(truth, p);
    EXPECT_EQ(apart.projections, 0U);
    p.farthest_m = 0.85;
    const Ends together = walk(truth, p);
    one.push_back(apart.left_m);
    free.push_back(apart.middle_m);
    bound.push_back(together.middle_m);
    worst_free.push_back(std::max(apart.left_m, apart.right_m));
    worst_bound.push_back(std::max(together.left_m, together.right_m));
    EXPECT_LT(together.apart_m, 0.85 + 0.2) << seed;
  }
  std::printf(
      "end after 194 m, root mean square over 20 seeds: one foot %.2f m, the middle of two %.2f, "
      "with the bound %.2f; the worse foot %.2f, with the bound %.2f\n",
      root_mean_square(one), root_mean_square(free), root_mean_square(bound),
      root_mean_square(worst_free), root_mean_square(worst_bound));
  EXPECT_LT(root_mean_square(bound), root_mean_square(one));
  EXPECT_LT(root_mean_square(worst_bound), 0.7 * root_mean_square(worst_free));
}

// The relative heading of the units is accounted for.
TEST(TwoFeet, UseTheRelativeMounting) {
  sim::FeetPlan plan;
  plan.strides = 20;
  auto truth = sim::simulate_feet(plan, {}, Rng(3));
  const SO3d mounted = SO3d::exp({0.0, 0.0, 0.7});
  for (ImuSample& s : truth.right.samples) {
    s.angular_rate_radps = mounted.inverse() * s.angular_rate_radps;
    s.specific_force_mps2 = mounted.inverse() * s.specific_force_mps2;
  }
  TwoFeetParameters p;
  p.right_from_left = Angle::radians(0.7);
  EXPECT_LT(walk(truth, p).right_m, 1.0);
  const TwoFeet feet = walked(truth, p);
  EXPECT_NEAR(feet.odometry().T_odom_base.raw().x(), truth.length_m, 0.5);
}

// Two straight tracks of one path, that of the right unit seen in axes turned by 0.7 rad.
TEST(TwoFeet, FindTheMountingFromTheTracks) {
  std::vector<Eigen::Vector2d> left, right;
  for (int i = 0; i <= 60; ++i) {
    left.emplace_back(0.1 * i * Eigen::Vector2d(std::cos(0.3), std::sin(0.3)));
    right.emplace_back(0.1 * i * Eigen::Vector2d(std::cos(0.3 - 0.7), std::sin(0.3 - 0.7)));
  }
  const auto mounting = feet_mounting(left, right, 0.2);
  ASSERT_TRUE(mounting);
  EXPECT_NEAR(mounting->right_from_left.radians(), 0.7, 1e-12);
  // To the right of the walking direction.
  EXPECT_NEAR(mounting->right_from_left_m.x(), 0.2 * std::sin(0.3), 1e-12);
  EXPECT_NEAR(mounting->right_from_left_m.y(), -0.2 * std::cos(0.3), 1e-12);
  left.resize(40);
  const auto error = feet_mounting(left, right, 0.2);
  ASSERT_FALSE(error);
  EXPECT_NE(error.error().message.find("do not get far enough"), std::string::npos);
  EXPECT_FALSE(feet_mounting({}, {}, 0.2));
}

}  // namespace
}  // namespace wayfare
