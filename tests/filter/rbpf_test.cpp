#include <wayfare/filter/rbpf.hpp>

#include <cmath>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include <wayfare/core/se3.hpp>

namespace wayfare {
namespace {

LogTime at_second(double s) { return LogTime::from_seconds(s); }
StampedPose start() { return {at_second(0), Transform2<frame::Map, frame::Base>(SE2d())}; }

/// A map of one landmark's position.
struct OneLandmark {
  std::vector<double> seen_at;
};

TEST(AncestryTree, RemovesUnreferencedTrajectories) {
  AncestryTree tree;
  AncestryTree::Node a = tree.add_root(start()), b = a;
  tree.retain(a);
  for (int i = 1; i <= 10; ++i) {
    const auto pose = [&](double y) {
      return StampedPose{at_second(i), Transform2<frame::Map, frame::Base>(SE2d(i, y, Angle{}))};
    };
    a = tree.append(a, pose(0));
    b = tree.append(b, pose(1));
  }
  EXPECT_EQ(tree.size(), 21U);  // the start is shared
  EXPECT_EQ(tree.trajectory(b).size(), 11U);
  EXPECT_EQ(tree.trajectory(b)[5].T_map_base.raw().y(), 1.0);
  tree.release(b);
  EXPECT_EQ(tree.size(), 11U);
  EXPECT_EQ(tree.trajectory(a)[5].T_map_base.raw().x(), 5.0);
  const AncestryTree::Node again = tree.append(a, start());
  EXPECT_EQ(tree.size(), 12U);  // in the memory of the removed trajectory
  tree.release(again);
  EXPECT_EQ(tree.size(), 0U);
}

// A chain as long as a day of scans is released without exhausting the stack.
TEST(AncestryTree, ReleasesLongTrajectories) {
  AncestryTree tree;
  AncestryTree::Node end = tree.add_root(start());
  for (int i = 0; i < 1000000; ++i) end = tree.append(end, start());
  tree.release(end);
  EXPECT_EQ(tree.size(), 0U);
}

// A robot on a line, its steps N(1, 0.2²), observes a landmark at 5 with σ = 0.1 after five of
// them. Its position then follows from the product of N(5, 5·0.2²) and N(5.3, 0.1²); the mean of
// the particles' first steps given that is 1 + (x − 5)/5.
TEST(Rbpf, WeighsWholeTrajectories) {
  constexpr std::size_t kParticles = 20000;
  Rbpf<OneLandmark> filter(kParticles, start(), {}, 3);
  for (int i = 1; i <= 5; ++i)
    ASSERT_TRUE(filter.update(at_second(i), [](auto& particle, Rng& rng, std::size_t) {
      particle.pose = particle.pose * SE2d(rng.normal(1.0, 0.2), 0, Angle{});
      particle.map.seen_at.push_back(particle.pose.x());
      return 0.0;
    }));
  EXPECT_NEAR(filter.effective_particles(), kParticles, 1e-6);
  ASSERT_TRUE(filter.update(at_second(6), [](auto& particle, Rng&, std::size_t) {
    const double d = (particle.pose.x() - 5.3) / 0.1;
    return -0.5 * d * d;
  }));
  const double variance = 5 * 0.04, expected = 5 + 0.3 * variance / (variance + 0.01);
  double mean = 0, first = 0;
  for (std::size_t i = 0; i < kParticles; ++i) {
    const double w = std::exp(filter.log_weights()[i]);
    mean += w * filter.particles()[i].pose.x();
    first += w * filter.particles()[i].map.seen_at.front();
  }
  // √(posterior variance / effective particles), four times.
  const double posterior = variance * 0.01 / (variance + 0.01);
  const double n = filter.effective_particles();
  EXPECT_NEAR(mean, expected, 4 * std::sqrt(posterior / n));
  EXPECT_NEAR(first, 1 + (expected - 5) / 5, 4 * 0.2 / std::sqrt(n));

  // After resampling, the estimate is the same with equal weights, and each particle keeps the
  // trajectory of its map.
  EXPECT_FALSE(filter.resample_below(n / kParticles - 0.01));
  EXPECT_TRUE(filter.resample_below(n / kParticles + 0.01));
  EXPECT_NEAR(filter.effective_particles(), kParticles, 1e-6);
  double after = 0;
  for (const auto& p : filter.particles()) after += p.pose.x() / kParticles;
  EXPECT_NEAR(after, mean, 4 * std::sqrt(posterior / kParticles));
  for (std::size_t i = 0; i < kParticles; i += 500) {
    const Trajectory trajectory = filter.trajectory(i);
    ASSERT_EQ(trajectory.size(), 7U);
    for (std::size_t k = 1; k <= 5; ++k)
      EXPECT_EQ(trajectory[k].T_map_base.raw().x(), filter.particles()[i].map.seen_at[k - 1]);
  }
  EXPECT_LT(filter.stored_poses(), 7 * kParticles);
}

// The same in space: the product of N(5, 5·0.2²) and N(5.3, 0.1²) along the way.
TEST(Rbpf, CarriesPosesInSpace) {
  constexpr std::size_t kParticles = 5000;
  const SO3d upside_down = SO3d::exp(Eigen::Vector3d(3.0, 0.0, 0.0));
  const StampedPoseOf<SE3d> from{at_second(0), Transform3<frame::Map, frame::Base>(
                                                   SE3d(Eigen::Vector3d::Zero(), upside_down))};
  Rbpf<OneLandmark, SE3d> filter(kParticles, from, {}, 3);
  for (int i = 1; i <= 5; ++i)
    ASSERT_TRUE(filter.update(at_second(i), [&](auto& particle, Rng& rng, std::size_t) {
      particle.pose = particle.pose * SE3d(Eigen::Vector3d(rng.normal(1.0, 0.2), 0.0, 0.0), SO3d());
      if (i < 5) return 0.0;
      const double d = (particle.pose.translation().x() - 5.3) / 0.1;
      return -0.5 * d * d;
    }));
  const double variance = 5 * 0.04, posterior = variance * 0.01 / (variance + 0.01);
  double mean = 0;
  for (std::size_t i = 0; i < kParticles; ++i)
    mean += std::exp(filter.log_weights()[i]) * filter.particles()[i].pose.translation().x();
  EXPECT_NEAR(mean, 5 + 0.3 * variance / (variance + 0.01),
              4 * std::sqrt(posterior / filter.effective_particles()));
  EXPECT_TRUE(filter.resample_below(1.0));
  const auto trajectory = filter.trajectory(filter.best());
  ASSERT_EQ(trajectory.size(), 6U);
  EXPECT_LT(trajectory[3].T_map_base.raw().rotation().minus(upside_down).norm(), 1e-9);
}

TEST(Rbpf, TheBestHasTheLargestEvidenceOfItsTrajectory) {
  Rbpf<OneLandmark> filter(3, start(), {}, 1);
  std::vector<double> factors{-1.0, -2.0, -5.0};
  std::size_t next = 0;
  const auto next_factor = [&](auto&, Rng&, std::size_t) { return factors[next++ % 3]; };
  ASSERT_TRUE(filter.update(at_second(1), next_factor));
  EXPECT_EQ(filter.best(), 0U);
  factors = {-6.0, -1.0, -3.0};
  ASSERT_TRUE(filter.update(at_second(2), next_factor));
  EXPECT_EQ(filter.best(), 1U);  // −3 against −7 and −8
}

// A measurement that fits no particle leaves the weights unchanged.
TEST(Rbpf, SurvivesACollapse) {
  Rbpf<OneLandmark> filter(4, start(), {}, 1);
  const auto said = filter.update(at_second(1), [](auto&, Rng&, std::size_t) {
    return -std::numeric_limits<double>::infinity();
  });
  ASSERT_FALSE(said);
  EXPECT_EQ(said.error().code, ErrorCode::numerical);
  EXPECT_NEAR(filter.effective_particles(), 4, 1e-9);
}

/// The indices in another order, as threads may take them.
struct Backwards {
  template <class F>
  void operator()(std::size_t n, const F& f) const {
    for (std::size_t i = n; i-- > 0;) f(i, i % 2);
  }
};

TEST(Rbpf, TheOrderOfWorkDoesNotMatter) {
  Rbpf<OneLandmark> a(50, start(), {}, 9), b(50, start(), {}, 9);
  const auto step = [](auto& particle, Rng& rng, std::size_t) {
    particle.pose = particle.pose * SE2d(rng.normal(1.0, 0.2), rng.normal(0, 0.1), Angle{});
    return -particle.pose.x() * particle.pose.x();
  };
  for (int i = 1; i < 20; ++i) {
    ASSERT_TRUE(a.update(at_second(i), step));
    ASSERT_TRUE(b.update(at_second(i), step, Backwards()));
    EXPECT_EQ(a.resample_below(), b.resample_below());
  }
  for (std::size_t i = 0; i < 50; ++i)
    EXPECT_EQ(a.particles()[i].pose.translation(), b.particles()[i].pose.translation());
}

}  // namespace
}  // namespace wayfare
