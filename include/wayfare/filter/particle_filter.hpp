#pragma once

// The steps of a particle filter on any manifold (Thrun, Burgard and Fox 2005, chapters 4 and 8),
// each a function; a filter is a sequence of them:
//
//   Particles<SE2d> particles = draw_particles(2000, GaussianSampler<SE2d>(start), rng.stream(0));
//   propagate(particles, motion, rng.stream(1));            // motion(state, rng) -> state
//   reweight(particles, likelihood);                        // likelihood(state) -> ln p
//   if (effective_sample_size(particles.log_weights) < 0.5 * particles.size())
//     particles = resample_adaptively(particles, bins, {}, rng);
//   const Gaussian<SE2d> estimate = mean_and_covariance(particles);
//
// Every block of 1024 particles has its own random stream: results do not depend on the number of
// threads. With more than one, what a caller passes is called concurrently.

#include <algorithm>
#include <atomic>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include <wayfare/core/finite.hpp>
#include <wayfare/core/gaussian.hpp>
#include <wayfare/core/gaussian_sampler.hpp>
#include <wayfare/core/manifold.hpp>
#include <wayfare/core/parallel.hpp>
#include <wayfare/core/random.hpp>
#include <wayfare/filter/detail/bin_counter.hpp>
#include <wayfare/filter/particles.hpp>

namespace wayfare {

/// Moves a state: `sampler(state, rng)` draws the state after the motion.
template <class F, class State>
concept StateSampler = requires(const F& sampler, const State& x, Rng& rng) {
  { sampler(x, rng) } -> std::convertible_to<State>;
};

/// Draws a state: `source(rng)`, e.g. GaussianSampler, or a pose anywhere in a map.
template <class F, class State>
concept StateSource = requires(const F& source, Rng& rng) {
  { source(rng) } -> std::convertible_to<State>;
};

/// `likelihood(state)` is ln p(measurement | state), up to a constant: finite or -inf.
template <class F, class State>
concept StateLikelihood = requires(const F& likelihood, const State& x) {
  { likelihood(x) } -> std::convertible_to<double>;
};

/// `bins(state)` is the bin of a histogram, a BinKey; PoseBins of pose_bins.hpp is one.
template <class F, class State>
concept StateBins = requires(const F& bins, const State& x) {
  {detail::BinCounterOf<decltype(bins(x))>()};
};

/// Weighted samples of a distribution. Weights need not be normalised.
template <Manifold State>
struct Particles {
  using Value = State;              ///< of one particle
  std::vector<State> states;        ///< one for each particle
  std::vector<double> log_weights;  ///< as many; -inf without weight

  /// Number of particles.
  [[nodiscard]] std::size_t size() const { return states.size(); }
  /// Whether there are none.
  [[nodiscard]] bool empty() const { return states.empty(); }
  /// Of particle `i`.
  [[nodiscard]] const State& state(std::size_t i) const { return states[i]; }
  /// Moves particle `i`; its weight stays.
  void set(std::size_t i, const State& x) { states[i] = x; }
  /// With equal weights; new states are at the origin.
  void resize(std::size_t n) {
    states.resize(n, manifold_origin<State>());
    log_weights.assign(n, 0.0);
  }
  /// Adds a particle of log-weight zero.
  void push_back(const State& x) {
    states.push_back(x);
    log_weights.push_back(0.0);
  }
};

/// Particles or a type that stores them otherwise, e.g. as a structure of arrays.
template <class P>
concept ParticleStorage = requires(P& p, const P& c, std::size_t i, const typename P::Value& x) {
  requires Manifold<typename P::Value>;
  { c.size() } -> std::convertible_to<std::size_t>;
  { c.state(i) } -> std::convertible_to<typename P::Value>;
  { p.log_weights } -> std::convertible_to<std::vector<double>&>;
  p.set(i, x);
  p.resize(i);
  p.push_back(x);
};

namespace detail {

inline constexpr std::size_t kParticleBlock = 1024;

/// f(i, rng) for n particles, with one random stream for each block.
template <class F>
void for_particles(std::size_t n, int threads, const Rng& rng, const F& f) {
  parallel_for((n + kParticleBlock - 1) / kParticleBlock, threads, [&](std::size_t b) {
    Rng own = rng.stream(b);
    for (std::size_t i = b * kParticleBlock; i < std::min(n, (b + 1) * kParticleBlock); ++i)
      f(i, own);
  });
}

}  // namespace detail

/// `count` particles of equal weight from a source.
template <class Source>
[[nodiscard]] auto draw_particles(std::size_t count, const Source& source, const Rng& rng,
                                  int threads = 1) {
  static_assert(std::invocable<const Source&, Rng&>,
                "wayfare: a source of states is called as source(rng), with Rng&");
  Particles<std::decay_t<decltype(source(std::declval<Rng&>()))>> drawn;
  drawn.resize(count);
  detail::for_particles(count, threads, rng,
                        [&](std::size_t i, Rng& own) { drawn.set(i, source(own)); });
  return drawn;
}

/// Moves every particle by its own sample. A sample that is not finite is refused: the particle
/// stays. Returns the number refused.
template <ParticleStorage P, class Sampler>
std::size_t propagate(P& particles, const Sampler& sampler, const Rng& rng, int threads = 1) {
  using State = typename P::Value;
  static_assert(StateSampler<Sampler, State>,
                "wayfare: a sampler of motions is called as sampler(state, rng), with Rng&, and "
                "returns the state after the motion");
  std::atomic<std::size_t> refused{0};
  detail::for_particles(particles.size(), threads, rng, [&](std::size_t i, Rng& own) {
    const State moved = sampler(particles.state(i), own);
    has_finite_value(moved) ? particles.set(i, moved) : static_cast<void>(++refused);
  });
  return refused;
}

/// log_likelihood[i] = likelihood(state i); NaN for a state that is not finite.
template <ParticleStorage P, class Likelihood>
void log_likelihoods(const P& particles, const Likelihood& likelihood, std::span<double> result,
                     int threads = 1) {
  using State = typename P::Value;
  static_assert(StateLikelihood<Likelihood, State>,
                "wayfare: a likelihood is called as likelihood(state) and returns a double, the "
                "logarithm of a density");
  const std::size_t n = particles.size(), block = detail::kParticleBlock;
  parallel_for((n + block - 1) / block, threads, [&](std::size_t b) {
    for (std::size_t i = b * block; i < std::min(n, (b + 1) * block); ++i) {
      const State& x = particles.state(i);
      result[i] = has_finite_value(x) ? static_cast<double>(likelihood(x))
                                      : std::numeric_limits<double>::quiet_NaN();
    }
  });
}

/// Multiplies the weights by exp(log_factors) and normalises them. Factors of NaN and +inf are
/// refused and counted: the particle has no weight. Where none would keep any weight, `collapsed`
/// is true and the weights are unchanged: the measurement is ignored.
template <ParticleStorage P>
Normalisation reweight_by(P& particles, std::span<const double> log_factors) {
  std::vector<double> joint(log_factors.begin(), log_factors.end());
  for (std::size_t i = 0; i < joint.size(); ++i) joint[i] += particles.log_weights[i];
  const Normalisation result = normalise(joint);
  if (!result.collapsed) particles.log_weights = std::move(joint);
  return result;
}

/// The same by a likelihood; `log_sum` is ln of its mean over the particles as weighted before, the
/// evidence of the measurement.
template <ParticleStorage P, class Likelihood>
Normalisation reweight(P& particles, const Likelihood& likelihood, int threads = 1) {
  std::vector<double> factors(particles.size());
  log_likelihoods(particles, likelihood, factors, threads);
  const double before = log_sum_exp(particles.log_weights);
  Normalisation result = reweight_by(particles, factors);
  result.log_sum -= before;
  return result;
}

/// The particles drawn, of equal weight.
template <ParticleStorage P>
[[nodiscard]] P select(const P& from, std::span<const ParticleIndex> drawn) {
  P result;
  for (const ParticleIndex i : drawn) result.push_back(from.state(i));
  return result;
}

/// `count` particles drawn by weight, of equal weight.
template <ParticleStorage P>
[[nodiscard]] P resample(const P& from, std::size_t count, Resampling scheme, Rng& rng) {
  return select(from, resample(from.log_weights, count, scheme, rng));
}

/// KLD sampling (Fox 2003): the number of particles follows their spread.
struct KldSampling {
  double error = 0.05;      ///< bound on the KL distance of the particles' histogram …
  double quantile = 2.326;  ///< … with this quantile of the normal distribution (99 %)
  std::size_t least = 500,  ///< number of particles, at least …
      most = 20000;         ///< … and at most
};

/// Fox 2003, equation (7): number of particles that bounds the Kullback-Leibler distance of a
/// histogram of `k` bins by the error.
[[nodiscard]] inline double kld_bound(std::size_t k, const KldSampling& kld) {
  if (k < 2) return 1.0;
  const double freedom = static_cast<double>(k - 1), ninth = 2.0 / (9.0 * freedom);
  const double cube = 1.0 - ninth + std::sqrt(ninth) * kld.quantile;
  return freedom / (2.0 * kld.error) * cube * cube * cube;
}

/// Draws by weight as many as KLD sampling requires; `key_of(i)` is the bin of particle i. Single
/// draws determine the number; the sample itself is drawn with low variance, so that neither of two
/// equally likely states wins by chance.
template <class KeyOf>
requires std::invocable<const KeyOf&, std::size_t>
[[nodiscard]] std::vector<ParticleIndex> resample_adaptively(std::span<const double> log_weights,
                                                             const KeyOf& key_of,
                                                             const KldSampling& kld, Rng& rng) {
  if (log_weights.empty()) return {};
  const std::vector<double> sums = detail::cumulated_weights(log_weights);
  detail::BinCounterOf<decltype(key_of(std::size_t{}))> seen;
  auto wanted = static_cast<double>(std::max<std::size_t>(kld.least, 1));
  std::size_t n = 0;
  for (; static_cast<double>(n) < wanted && n < kld.most; ++n) {
    const double at = rng.uniform() * sums.back();
    const auto i = static_cast<std::size_t>(
        std::min(std::upper_bound(sums.begin(), sums.end(), at) - sums.begin(),
                 static_cast<std::ptrdiff_t>(sums.size()) - 1));
    if (seen.add(key_of(i))) wanted = std::max(wanted, kld_bound(seen.count(), kld));
  }
  return resample(log_weights, n, Resampling::low_variance, rng);
}

/// The same with the bins of states.
template <ParticleStorage P, class Bins>
[[nodiscard]] P resample_adaptively(const P& from, const Bins& bins, const KldSampling& kld,
                                    Rng& rng) {
  static_assert(StateBins<Bins, typename P::Value>,
                "wayfare: bins are called as bins(state) and return a BinKey, the indices of the "
                "state's bin");
  const auto key_of = [&](std::size_t i) { return bins(from.state(i)); };
  return select(from, resample_adaptively(from.log_weights, key_of, kld, rng));
}

/// Σ w (x ⊟ mean)(x ⊟ mean)ᵀ / Σ w of the members, about a given mean.
template <ParticleStorage P, class Members>
[[nodiscard]] SquareOf<typename P::Value> covariance_about(const typename P::Value& mean,
                                                           const P& particles,
                                                           std::span<const double> weights,
                                                           const Members& members) {
  using State = typename P::Value;
  double sum = 0.0;
  for (const auto i : members) sum += weights[i];
  SquareOf<State> covariance = SquareOf<State>::Zero();
  for (const auto i : members) {
    const TangentOf<State> off = ManifoldTraits<State>::minus(particles.state(i), mean);
    covariance += weights[i] / sum * off * off.transpose();
  }
  return covariance;
}

/// The mean m of the members with Σ w (x ⊟ m) = 0, by Newton steps from the heaviest.
template <ParticleStorage P, class Members>
[[nodiscard]] typename P::Value intrinsic_mean(const P& particles, std::span<const double> weights,
                                               const Members& members) {
  using State = typename P::Value;
  constexpr int kMostSteps = 30;
  constexpr double kConverged = 1e-20;
  State mean = particles.state(*std::max_element(
      members.begin(), members.end(), [&](auto a, auto b) { return weights[a] < weights[b]; }));
  for (int k = 0; k < kMostSteps; ++k) {
    TangentOf<State> step = TangentOf<State>::Zero();
    double sum = 0.0, spread = 0.0;
    for (const auto i : members) {
      const TangentOf<State> off = ManifoldTraits<State>::minus(particles.state(i), mean);
      step += weights[i] * off;
      spread += weights[i] * off.squaredNorm();
      sum += weights[i];
    }
    mean = ManifoldTraits<State>::plus(mean, (step / sum).eval());
    if (!(step.squaredNorm() > kConverged * sum * spread)) break;
  }
  return mean;
}

/// Weighted mean and covariance of a set that is not empty, on the manifold.
template <ParticleStorage P>
[[nodiscard]] Gaussian<typename P::Value> mean_and_covariance(const P& particles) {
  const std::vector<double> weights = normalised_weights(particles.log_weights);
  std::vector<ParticleIndex> all;
  for (std::size_t i = 0; i < weights.size(); ++i)
    if (weights[i] > 0.0) all.push_back(static_cast<ParticleIndex>(i));
  Gaussian<typename P::Value> result;
  result.mean = intrinsic_mean(particles, weights, all);
  result.covariance = covariance_about(result.mean, particles, weights, all);
  return result;
}

/// Random injection: replaces each particle with this probability by a state of the source, which
/// keeps its weight; one that is not finite is refused. Draw it after resampling, with the
/// probability of RecoveryProbability.
template <ParticleStorage P, class Source>
void inject(P& particles, double probability, const Source& source, const Rng& rng,
            int threads = 1) {
  static_assert(StateSource<Source, typename P::Value>,
                "wayfare: a source of states is called as source(rng), with Rng&, and returns a "
                "state");
  detail::for_particles(particles.size(), threads, rng, [&](std::size_t i, Rng& own) {
    if (!(own.uniform() < probability)) return;
    if (const typename P::Value x = source(own); has_finite_value(x)) particles.set(i, x);
  });
}

/// Probability of random injection from two moving averages of a measurement's mean likelihood
/// (augmented Monte-Carlo localisation, Thrun et al. 2005, table 8.3): positive where the recent
/// measurements fit worse than usual.
class RecoveryProbability {
 public:
  /// Rates of the two averages per measurement, 0 ≤ slow < fast ≤ 1.
  explicit RecoveryProbability(double slow = 0.001, double fast = 0.1) : slow_(slow), fast_(fast) {}

  /// `log_mean_likelihood`: Normalisation::log_sum of reweight(). One that is not finite is
  /// ignored.
  double update(double log_mean_likelihood) {
    if (!std::isfinite(log_mean_likelihood)) return probability();
    const double w = std::exp(log_mean_likelihood);
    mean_slow_ += (mean_slow_ == 0.0 ? 1.0 : slow_) * (w - mean_slow_);
    mean_fast_ += (mean_fast_ == 0.0 ? 1.0 : fast_) * (w - mean_fast_);
    return probability();
  }
  /// 1 − fast/slow average, at least zero; zero before the first measurement.
  [[nodiscard]] double probability() const {
    return mean_slow_ > 0.0 ? std::max(0.0, 1.0 - mean_fast_ / mean_slow_) : 0.0;
  }

 private:
  double slow_, fast_, mean_slow_ = 0.0, mean_fast_ = 0.0;
};

}  // namespace wayfare
