#include <wayfare/filter/particle_filter.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include <wayfare/core/gaussian_sampler.hpp>
#include <wayfare/core/se3.hpp>
#include <wayfare/core/statistics.hpp>
#include <wayfare/filter/pose_bins.hpp>
#include <wayfare/testing/particle_laws.hpp>

namespace wayfare {
namespace {

constexpr double kInf = std::numeric_limits<double>::infinity();
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
using Line = Eigen::Matrix<double, 1, 1>;

Particles<SE3d> around(const Gaussian<SE3d>& g, std::size_t n, int threads = 1) {
  return draw_particles(n, GaussianSampler<SE3d>(g), Rng(3), threads);
}
Gaussian<SE3d> in_space() {
  Gaussian<SE3d> g;
  TangentOf<SE3d> place;
  place << 1.0, -2.0, 0.5, 0.3, -0.2, 3.0;
  g.mean = SE3d::exp(place);
  g.covariance = 0.01 * SquareOf<SE3d>::Identity();
  g.covariance(0, 5) = g.covariance(5, 0) = 0.006;
  return g;
}

TEST(ParticleFilter, ConvergesToKalmansPosterior) {
  testing::check_filter_step(
      [](auto& particles, const auto& motion, const auto& likelihood, Rng& rng) {
        propagate(particles, motion, rng.stream(0));
        EXPECT_FALSE(reweight(particles, likelihood).collapsed);
        particles = resample(particles, particles.size(), Resampling::low_variance, rng);
      });
}

TEST(ParticleFilter, FollowsAnyManifold) {
  const Gaussian<SE3d> g = in_space();
  const Particles<SE3d> particles = around(g, 20000);
  testing::expect_samples_follow(g, particles.states);
  const Gaussian<SE3d> found = mean_and_covariance(particles);
  // The mean's definition; its error against the truth is σ/√n.
  TangentOf<SE3d> sum = TangentOf<SE3d>::Zero();
  for (const SE3d& x : particles.states) sum += x.minus(found.mean) / 20000.0;
  EXPECT_LT(sum.norm(), 1e-9);
  EXPECT_LT(found.mean.minus(g.mean).cwiseAbs().maxCoeff(), 6.0 * 0.1 / std::sqrt(20000.0));
  EXPECT_LT((found.covariance - g.covariance).cwiseAbs().maxCoeff(), 6.0 * 0.015 / std::sqrt(2e4));
}

TEST(ParticleFilter, SameBytesForAnyNumberOfThreads) {
  const auto filter = [](int threads) {
    Particles<SE3d> particles = around(in_space(), 5000, threads);
    const GaussianSampler<SE3d> step({SE3d(), 0.01 * SquareOf<SE3d>::Identity()});
    propagate(
        particles, [&](const SE3d& x, Rng& rng) { return x * step(rng); }, Rng(4), threads);
    reweight(
        particles, [](const SE3d& x) { return -x.translation().squaredNorm(); }, threads);
    Rng rng(5);
    particles = resample_adaptively(particles, SpatialPoseBins(0.1, 15.0_deg), {}, rng);
    inject(particles, 0.2, GaussianSampler<SE3d>(Gaussian<SE3d>{}), Rng(6), threads);
    return particles;
  };
  const Particles<SE3d> one = filter(1), three = filter(3);
  ASSERT_EQ(one.size(), three.size());
  for (std::size_t i = 0; i < one.size(); ++i)
    ASSERT_EQ(one.state(i).translation(), three.state(i).translation()) << i;
}

TEST(ParticleFilter, RefusesWhatIsNotFinite) {
  Particles<Line> particles;
  for (int i = 0; i < 4; ++i) particles.push_back(Line(i));
  const std::size_t stay = propagate(
      particles, [](const Line& x, Rng&) { return Line(x[0] < 2.0 ? kNan : x[0] + 1.0); }, Rng(1));
  EXPECT_EQ(stay, 2U);
  EXPECT_EQ(particles.state(1)[0], 1.0);
  EXPECT_EQ(particles.state(3)[0], 4.0);
  const Normalisation some = reweight(particles, [](const Line& x) {
    return x[0] == 0.0 ? kNan : x[0] == 1.0 ? kInf : x[0] == 3.0 ? -kInf : -1.0;
  });
  EXPECT_EQ(some.refused, 2U);
  EXPECT_NEAR(some.log_sum, -1.0 - std::log(4.0), 1e-12);  // e⁻¹ of one in four
  EXPECT_FALSE(some.collapsed);
  EXPECT_EQ(particles.log_weights, (std::vector<double>{-kInf, -kInf, -kInf, 0.0}));
  const Normalisation none = reweight(particles, [](const Line&) { return -kInf; });
  EXPECT_TRUE(none.collapsed);
  EXPECT_EQ(particles.log_weights.back(), 0.0);
  inject(
      particles, 1.0, [](Rng&) { return Line(kNan); }, Rng(1));
  EXPECT_EQ(particles.state(3)[0], 4.0);
}

// Particles spread over more bins need more; a set in one bin the least number.
TEST(ResampleAdaptively, TheNumberFollowsTheSpread) {
  const auto bins = [](const Line& x) {
    return BinKey<1>{static_cast<std::int32_t>(std::floor(x[0]))};
  };
  const auto drawn = [&](double width) {
    Rng rng(1);
    const auto uniform = [&](Rng& r) { return Line(r.uniform(0.0, width)); };
    const Particles<Line> particles = draw_particles(5000, uniform, Rng(2));
    return resample_adaptively(particles, bins, {0.05, 2.326, 50, 4000}, rng).size();
  };
  EXPECT_EQ(drawn(0.5), 50U);
  // All of the bins are occupied: the bound of 20 bins.
  EXPECT_EQ(drawn(20.0), static_cast<std::size_t>(std::ceil(kld_bound(20, {}))));
  EXPECT_EQ(drawn(4000.0), 4000U);
  Rng rng(1);
  EXPECT_TRUE(resample_adaptively(Particles<Line>{}, bins, {}, rng).empty());
}

// Fox's (7) is the approximation of Wilson and Hilferty of χ²(99 %; k − 1)/2ε, within 0.8 % of it
// for one degree of freedom, and closer for more.
TEST(KldBound, IsAQuantileOfTheChiSquareDistribution) {
  for (const std::size_t k : {2U, 3U, 11U, 51U}) {
    const double quantile = chi_square_quantile(0.99, static_cast<double>(k - 1));
    EXPECT_NEAR(kld_bound(k, {}) / (quantile / (2.0 * 0.05)), 1.0, k == 2 ? 0.01 : 0.002) << k;
  }
  EXPECT_EQ(kld_bound(1, {}), 1.0);
  EXPECT_EQ(kld_bound(0, {}), 1.0);
}

// Weights 1 and 3 at 0 and 4: mean 3, variance (1·3² + 3·1²)/4 = 3.
TEST(IntrinsicMean, IsThatOfWeightsOfAnySum) {
  Particles<Line> particles;
  for (const double x : {0.0, 4.0}) particles.push_back(Line(x));
  const std::vector<double> weights{1.0, 3.0};
  const std::vector<ParticleIndex> both{0, 1};
  const Line mean = intrinsic_mean(particles, weights, both);
  EXPECT_NEAR(mean[0], 3.0, 1e-12);
  EXPECT_NEAR(covariance_about(mean, particles, weights, both)(0), 3.0, 1e-12);
}

TEST(Inject, ReplacesTheShareAskedFor) {
  Particles<Line> particles;
  particles.resize(20000);
  for (std::size_t i = 0; i < particles.size(); ++i) particles.set(i, Line(0.0));
  inject(
      particles, 0.3, [](Rng&) { return Line(1.0); }, Rng(1));
  double share = 0.0;
  for (const Line& x : particles.states) share += x[0] / 20000.0;
  EXPECT_NEAR(share, 0.3, 5.0 * std::sqrt(0.21 / 20000.0));
}

// Thrun et al. 2005, table 8.3: 1 − w_fast / w_slow.
TEST(RecoveryProbability, IsPositiveWhereMeasurementsFitWorseThanUsual) {
  RecoveryProbability recovery(0.01, 0.5);
  EXPECT_EQ(recovery.probability(), 0.0);
  for (int i = 0; i < 10; ++i) EXPECT_EQ(recovery.update(-1.0), 0.0);
  const double slow = std::exp(-1.0) + 0.01 * (std::exp(-3.0) - std::exp(-1.0));
  const double fast = 0.5 * (std::exp(-3.0) + std::exp(-1.0));
  EXPECT_NEAR(recovery.update(-3.0), 1.0 - fast / slow, 1e-12);
  EXPECT_EQ(recovery.update(-kInf), recovery.probability());
}

// At a heading of ±π, and beside it, a cluster does not fall apart.
TEST(SpatialPoseBins, WrapRollAndYaw) {
  const SpatialPoseBins bins(0.5, 15.0_deg);
  const auto at = [](double roll, double yaw) {
    return SE3d(Eigen::Vector3d(0.1, 0.1, 0.1),
                rotation_from_roll_pitch_yaw(Eigen::Vector3d(roll, 0.05, yaw)));
  };
  constexpr double kPi = std::numbers::pi;
  std::vector<SpatialPoseBins::Key> keys;
  for (const double off : {-0.1, 0.1}) {
    keys.push_back(bins(at(0.05, kPi + off)));
    keys.push_back(bins(at(kPi + off, 0.05)));
  }
  const std::vector<double> weights{0.3, 0.2, 0.3, 0.2};
  const auto clusters = find_clusters<SpatialPoseBins>(keys, weights, bins);
  ASSERT_EQ(clusters.size(), 2U);
  EXPECT_NEAR(clusters[0].mass, 0.6, 1e-12);
}

}  // namespace
}  // namespace wayfare
