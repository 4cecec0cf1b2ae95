// Factors that are not numbers, or mean that a measurement is impossible, compared with a model
// that keeps plain weights instead of logarithms.

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numeric>
#include <span>
#include <vector>

#include <gtest/gtest.h>

#include <wayfare/core/random.hpp>
#include <wayfare/filter/rbpf.hpp>

namespace wayfare {
namespace {

constexpr double kInf = std::numeric_limits<double>::infinity();
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

LogTime at_second(double s) { return LogTime::from_seconds(s); }
StampedPose start() { return {at_second(0), Transform2<frame::Map, frame::Base>(SE2d())}; }

/// A map that stores which particle of the last update it comes from.
struct Origin {
  std::size_t index = 0;
};
using Filter = Rbpf<Origin>;

bool refused(double factor) { return std::isnan(factor) || factor == kInf; }

/// Moves every particle along and weighs it by its factor, one after the other.
Result<Normalisation> update(Filter& filter, double s, const std::vector<double>& factors) {
  std::size_t next = 0;
  return filter.update(at_second(s), [&](auto& particle, Rng& rng, std::size_t) {
    particle.pose = particle.pose * SE2d(rng.normal(1.0, 0.2), rng.normal(0.0, 0.1), Angle{});
    particle.map.index = next;
    return factors[next++];
  });
}

/// Weights and evidence by the definition.
struct Model {
  explicit Model(std::size_t n) : weights(n, 1.0 / static_cast<double>(n)), evidence(n, 0.0) {}

  std::vector<double> weights, evidence;

  /// False, with nothing changed, where no weight is left.
  bool update(const std::vector<double>& factors) {
    std::vector<double> next = weights;
    for (std::size_t i = 0; i < next.size(); ++i)
      next[i] *= refused(factors[i]) ? 0.0 : std::exp(factors[i]);
    const double sum = std::accumulate(next.begin(), next.end(), 0.0);
    if (sum == 0.0) return false;
    for (std::size_t i = 0; i < next.size(); ++i) {
      weights[i] = next[i] / sum;
      evidence[i] = weights[i] > 0.0 ? evidence[i] + factors[i] : -kInf;
    }
    return true;
  }
  [[nodiscard]] double effective() const {
    return 1.0 / std::inner_product(weights.begin(), weights.end(), weights.begin(), 0.0);
  }
  [[nodiscard]] std::size_t best() const {
    std::size_t best = 0;
    for (std::size_t i = 0; i < weights.size(); ++i)
      if (weights[i] > 0.0 && (!(weights[best] > 0.0) || evidence[i] > evidence[best])) best = i;
    return best;
  }
  /// Resamples as the filter did.
  void take(std::span<const Filter::Particle> drawn) {
    std::vector<double> of_drawn;
    for (const auto& particle : drawn) of_drawn.push_back(evidence[particle.map.index]);
    evidence = of_drawn;
    weights.assign(drawn.size(), 1.0 / static_cast<double>(drawn.size()));
  }
};

void expect_same(const Filter& filter, const Model& model) {
  for (std::size_t i = 0; i < model.weights.size(); ++i) {
    ASSERT_NEAR(std::exp(filter.log_weights()[i]), model.weights[i], 1e-12);
    ASSERT_EQ(filter.log_weights()[i] == -kInf, model.weights[i] == 0.0);
    ASSERT_EQ(filter.particles()[i].log_evidence, model.evidence[i]);
  }
  ASSERT_NEAR(filter.effective_particles(), model.effective(), 1e-9);
  ASSERT_EQ(filter.best(), model.best());
}

/// Particles are drawn n·w ± 1 times (low variance); none without weight.
void expect_drawn_by_weight(const Filter& filter, const Model& before) {
  std::vector<double> count(before.weights.size());
  for (const auto& particle : filter.particles()) ++count[particle.map.index];
  for (std::size_t i = 0; i < count.size(); ++i) {
    const double expected = static_cast<double>(count.size()) * before.weights[i];
    ASSERT_LT(std::abs(count[i] - expected), 1.0 + 1e-9);
    if (before.weights[i] == 0.0) {
      ASSERT_EQ(count[i], 0.0);
    }
  }
}

void expect_step(Filter& filter, Model& model, double s, const std::vector<double>& factors) {
  const auto said = update(filter, s, factors);
  ASSERT_EQ(said.has_value(), model.update(factors));
  if (said) {
    ASSERT_EQ(said->refused,
              static_cast<std::size_t>(std::count_if(factors.begin(), factors.end(), refused)));
  } else {
    ASSERT_EQ(said.error().code, ErrorCode::numerical);
  }
  expect_same(filter, model);
}

void expect_resampling(Filter& filter, Model& model) {
  const double half = 0.5 * static_cast<double>(model.weights.size());
  const bool resampled = filter.resample_below();
  if (std::abs(model.effective() - half) > 1e-9) {
    ASSERT_EQ(resampled, model.effective() < half);
  }
  if (!resampled) return;
  expect_drawn_by_weight(filter, model);
  model.take(filter.particles());
  expect_same(filter, model);
}

std::vector<double> random_factors(std::size_t n, double share, Rng& rng) {
  constexpr std::array kOdd{kNan, -kInf, kInf, -kNan};
  std::vector<double> factors(n);
  for (double& f : factors)
    f = rng.uniform() < share ? kOdd[static_cast<std::size_t>(rng.uniform(0.0, 4.0))]
                              : rng.uniform(-3.0, 3.0);
  return factors;
}

// Every pattern of four particles in two updates, 4⁴ · 4⁴, then one that all can explain.
TEST(RbpfRefusal, EveryOrderOfTwoUpdatesFollowsTheModel) {
  constexpr std::array kKinds{-0.7, kNan, -kInf, kInf};
  const auto pattern = [&](std::size_t code) {
    std::vector<double> factors(4);
    for (std::size_t i = 0; i < 4; ++i, code /= 4) {
      factors[i] = kKinds[code % 4];
      if (code % 4 == 0) factors[i] *= static_cast<double>(i + 1);
    }
    return factors;
  };
  for (std::size_t code = 0; code < 65536 && !HasFatalFailure(); ++code) {
    SCOPED_TRACE(code);
    Filter filter(4, start(), {}, code);
    Model model(4);
    expect_step(filter, model, 1, pattern(code % 256));
    expect_step(filter, model, 2, pattern(code / 256));
    expect_step(filter, model, 3, {-1.0, -0.5, -0.2, -0.1});
    expect_resampling(filter, model);
    expect_step(filter, model, 4, {-0.1, -0.2, -0.5, -1.0});
  }
}

TEST(RbpfRefusal, RandomPatternsFollowTheModel) {
  Rng rng(17);
  for (int run = 0; run < 2000 && !HasFatalFailure(); ++run) {
    SCOPED_TRACE(run);
    const auto n = static_cast<std::size_t>(rng.uniform(1.0, 12.0));
    const double share = rng.uniform(0.0, 1.0);
    Filter filter(n, start(), {}, static_cast<std::uint64_t>(run));
    Model model(n);
    for (int i = 1; i <= 12 && !HasFatalFailure(); ++i) {
      expect_step(filter, model, i, random_factors(n, share, rng));
      if (rng.uniform() < 0.5) expect_resampling(filter, model);
    }
  }
}

/// Bit for bit: -0.0 and 0.0 would differ too.
void expect_same_bits(const Filter& a, const Filter& b) {
  for (std::size_t i = 0; i < a.particles().size(); ++i) {
    ASSERT_EQ(std::bit_cast<std::uint64_t>(a.log_weights()[i]),
              std::bit_cast<std::uint64_t>(b.log_weights()[i]));
    const auto &p = a.particles()[i], &q = b.particles()[i];
    ASSERT_EQ(std::bit_cast<std::uint64_t>(p.log_evidence),
              std::bit_cast<std::uint64_t>(q.log_evidence));
    ASSERT_EQ(p.pose.translation(), q.pose.translation());
    ASSERT_EQ(p.map.index, q.map.index);
    ASSERT_EQ(a.trajectory(i).size(), b.trajectory(i).size());
  }
}

// A refused factor has the effect of an impossible measurement on the other particles.
TEST(RbpfRefusal, OthersGoOnAsIfTheWeightWereZero) {
  Rng rng(23);
  for (int run = 0; run < 300 && !HasFatalFailure(); ++run) {
    SCOPED_TRACE(run);
    Filter odd(9, start(), {}, 5), zero(9, start(), {}, 5);
    const double share = rng.uniform(0.0, 0.9);
    for (int i = 1; i <= 10 && !HasFatalFailure(); ++i) {
      std::vector<double> factors = random_factors(9, share, rng);
      const bool valid = update(odd, i, factors).has_value();
      std::replace_if(factors.begin(), factors.end(), refused, -kInf);
      ASSERT_EQ(update(zero, i, factors).has_value(), valid);
      ASSERT_EQ(odd.resample_below(), zero.resample_below());
      expect_same_bits(odd, zero);
    }
  }
}

// The sum of the factors and, for the weights, each sum normalised: the same operations.
TEST(RbpfRefusal, FiniteFactorsAreSummedAndNormalisedAndNothingElse) {
  Rng rng(29);
  Filter filter(30, start(), {}, 2);
  std::vector<double> weights(30, -std::log(30.0)), evidence(30, 0.0);
  for (int i = 1; i <= 200; ++i) {
    const std::vector<double> factors = random_factors(30, 0.0, rng);
    const auto said = update(filter, i, factors);
    for (std::size_t k = 0; k < 30; ++k) {
      weights[k] += factors[k];
      evidence[k] += factors[k];
    }
    const Normalisation expected = normalise(weights);
    ASSERT_TRUE(said);
    ASSERT_EQ(said->log_sum, expected.log_sum);
    ASSERT_EQ(said->refused, 0U);
    for (std::size_t k = 0; k < 30; ++k) {
      ASSERT_EQ(filter.log_weights()[k], weights[k]);
      ASSERT_EQ(filter.particles()[k].log_evidence, evidence[k]);
    }
  }
}

TEST(RbpfRefusal, APoseThatIsNotFiniteIsRefusedLikeItsFactor) {
  for (const SE2d& bad :
       {SE2d(kNan, 0, Angle{}), SE2d(0, -kInf, Angle{}), SE2d(0, 0, Angle::radians(kNan))}) {
    Filter filter(3, start(), {}, 1);
    std::size_t next = 0;
    const auto said = filter.update(at_second(1), [&](auto& particle, Rng&, std::size_t) {
      if (next++ == 0) particle.pose = bad;
      return next == 1 ? 5.0 : -1.0;
    });
    ASSERT_TRUE(said);
    EXPECT_EQ(said->refused, 1U);
    EXPECT_EQ(filter.log_weights()[0], -kInf);
    EXPECT_EQ(filter.best(), 1U);
    EXPECT_NEAR(filter.effective_particles(), 2.0, 1e-12);
    ASSERT_TRUE(filter.resample_below(0.9));
    for (const auto& particle : filter.particles()) EXPECT_EQ(particle.pose.x(), 0.0);
  }
}

// Every particle has a pose for every update, also for one refused for all particles.
TEST(RbpfRefusal, AnUpdateRefusedInWholeMovesTheParticlesAndKeepsTheirWeights) {
  Filter filter(3, start(), {}, 1);
  ASSERT_TRUE(update(filter, 1, {-1.0, kNan, -2.0}));
  const std::vector<double> weights(filter.log_weights().begin(), filter.log_weights().end());
  const double x = filter.particles()[0].pose.x();
  EXPECT_FALSE(update(filter, 2, {kNan, 0.0, -kInf}));
  EXPECT_EQ(weights, std::vector<double>(filter.log_weights().begin(), filter.log_weights().end()));
  EXPECT_EQ(filter.particles()[0].log_evidence, -1.0);
  EXPECT_NE(filter.particles()[0].pose.x(), x);
  EXPECT_EQ(filter.trajectory(0).size(), 3U);
  EXPECT_EQ(filter.best(), 0U);
}

}  // namespace
}  // namespace wayfare
