#pragma once

// The laws of the parts of a particle filter, as checks on any type:
//
//   ParticleLaws<SE2d> laws;
//   laws.check_likelihood([&](const SE2d& x) { return mine.log_likelihood(x, scan, map); },
//   around); laws.check_sampler(sampler_of_odometry(mine, increment), promised);
//   check_filter_step(step);                  // one step of a filter against Kalman's

#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include <Eigen/Core>

#include <wayfare/core/finite.hpp>
#include <wayfare/core/gaussian.hpp>
#include <wayfare/filter/particle_filter.hpp>
#include <wayfare/testing/filter_laws.hpp>

namespace wayfare::testing {

/// Fails the current test where a likelihood or a motion breaks what a particle filter relies on.
template <Manifold State>
struct ParticleLaws {
  int trials = 200;        ///< states of check_likelihood
  int samples = 20000;     ///< draws of check_sampler
  std::uint64_t seed = 1;  ///< of states and draws

  /// At states drawn from `around` the likelihood is finite or -inf, and the same bits whatever it
  /// was asked before.
  template <class Likelihood>
  void check_likelihood(const Likelihood& likelihood, const Gaussian<State>& around) const {
    Rng rng(seed);
    std::vector<State> states;
    std::vector<double> first;
    for (int i = 0; i < trials; ++i) {
      states.push_back(sample(around, rng));
      first.push_back(likelihood(states.back()));
      EXPECT_FALSE(std::isnan(first.back())) << "likelihood of state " << i;
      EXPECT_LT(first.back(), std::numeric_limits<double>::infinity()) << "of state " << i;
    }
    for (std::size_t i = states.size(); i-- > 0;)
      EXPECT_EQ(std::bit_cast<std::uint64_t>(static_cast<double>(likelihood(states[i]))),
                std::bit_cast<std::uint64_t>(first[i]))
          << "asked again for state " << i;
  }

  /// Samples of a motion from `start` are finite, follow the distribution promised for the state
  /// after it, and are the same for the same random numbers.
  template <class Sampler>
  void check_sampler(const Sampler& sampler, const Gaussian<State>& promised,
                     const State& start = manifold_origin<State>(), double curvature = 0.0) const {
    Rng rng(seed), again(seed);
    std::vector<State> drawn;
    for (int i = 0; i < samples; ++i) {
      drawn.push_back(sampler(start, rng));
      ASSERT_TRUE(has_finite_value(drawn.back())) << "sample " << i;
      const State same = sampler(start, again);
      ASSERT_EQ(ManifoldTraits<State>::minus(same, drawn.back()),
                ManifoldTraits<State>::minus(drawn.back(), drawn.back()))
          << "sample " << i << " drawn again";
    }
    expect_samples_follow(promised, drawn, 6.0, curvature);
  }
};

/// A cart on a line, its position and speed, with measured positions: after ten steps the particles
/// have the mean and covariance of a Kalman filter, which is exact for this problem.
/// `step(particles, motion, likelihood, rng)` is one step of the filter under test.
template <class Step>
void check_filter_step(const Step& step, std::size_t count = 20000, std::uint64_t seed = 1) {
  using State = Eigen::Vector2d;
  constexpr double kDt_s = 0.5, kNoise_m = 0.4;
  Eigen::Matrix2d phi, q;
  phi << 1.0, kDt_s, 0.0, 1.0;
  q << 0.02, 0.01, 0.01, 0.04;
  const Gaussian<State> start{State(1.0, 0.5), State(1.0, 0.25).asDiagonal()};
  const Rng rng(seed);
  auto particles = draw_particles(count, GaussianSampler<State>(start), rng.stream(0));
  const GaussianSampler<State> noise({State::Zero(), q});
  State mean = start.mean;
  Eigen::Matrix2d covariance = start.covariance;
  Rng measurements = rng.stream(1);
  State truth(1.5, 0.8);
  for (std::uint64_t k = 0; k < 10; ++k) {
    truth = phi * truth;
    const double z = measurements.normal(truth[0], kNoise_m);
    mean = phi * mean;
    covariance = phi * covariance * phi.transpose() + q;
    const double s = covariance(0, 0) + kNoise_m * kNoise_m;
    const State gain = covariance.col(0) / s;
    mean += gain * (z - mean[0]);
    covariance -= gain * s * gain.transpose();
    Rng own = rng.stream(2 + k);
    step(
        particles, [&](const State& x, Rng& r) -> State { return phi * x + noise(r); },
        [&](const State& x) {
          const double d = (x[0] - z) / kNoise_m;
          return -0.5 * d * d;
        },
        own);
  }
  const Gaussian<State> found = mean_and_covariance(particles);
  // Standard error of a mean of n equal weights is σ/√n; resampling and weights at every step make
  // it as that of a tenth of the particles or better.
  const double error = 5.0 / std::sqrt(0.1 * static_cast<double>(count));
  for (int i = 0; i < 2; ++i) {
    EXPECT_NEAR(found.mean[i], mean[i], error * std::sqrt(covariance(i, i))) << "mean " << i;
    for (int j = 0; j < 2; ++j)
      EXPECT_NEAR(found.covariance(i, j), covariance(i, j),
                  2.0 * error * std::sqrt(covariance(i, i) * covariance(j, j)))
          << "covariance " << i << ", " << j;
  }
}

}  // namespace wayfare::testing
