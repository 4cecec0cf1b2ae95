#pragma once

// Weights of a set of particles and drawing from them. Weights are kept as logarithms and need not
// be normalised: the product of a few hundred likelihoods is below the smallest double.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include <wayfare/core/random.hpp>

namespace wayfare {

/// The particle drawn, by its place in the set drawn from.
using ParticleIndex = std::uint32_t;

/// The largest weight that is a number, -inf where there is none. NaN and +inf are no weights: a
/// likelihood that could not be worked out counts for nothing.
[[nodiscard]] inline double max_log_weight(std::span<const double> log_weights) {
  double best = -std::numeric_limits<double>::infinity();
  for (const double l : log_weights)
    if (l > best && l < std::numeric_limits<double>::infinity()) best = l;
  return best;
}

/// exp(log_weight − max), 0 for what is no weight.
[[nodiscard]] inline double relative_weight(double log_weight, double max) {
  const double difference = log_weight - max;
  return difference <= 0.0 ? std::exp(difference) : 0.0;  // false for NaN and +inf
}

/// ln Σ exp lᵢ without overflow or underflow; -inf for an empty set and where no weight is a
/// number.
[[nodiscard]] inline double log_sum_exp(std::span<const double> log_weights) {
  const double max = max_log_weight(log_weights);
  if (!std::isfinite(max)) return max;
  double sum = 0.0;
  for (const double l : log_weights) sum += relative_weight(l, max);
  return max + std::log(sum);
}

struct Normalisation {
  /// ln of what the weights summed to: the evidence of the measurement, where they summed to one
  /// before it. -inf after a collapse.
  double log_sum = 0.0;
  std::size_t refused = 0;  ///< weights that were NaN or +inf, now of no weight
  /// No particle had any weight left, so that all now have the same: the measurement fits no
  /// particle and said nothing.
  bool collapsed = false;
};

/// Makes the weights sum to one.
inline Normalisation normalise(std::span<double> log_weights) {
  Normalisation result{log_sum_exp(log_weights), 0, false};
  result.collapsed = !std::isfinite(result.log_sum);
  const double equal = -std::log(static_cast<double>(log_weights.size()));
  for (double& l : log_weights) {
    const bool number = l < std::numeric_limits<double>::infinity();
    result.refused += number ? 0 : 1;
    l = number ? l - result.log_sum : -std::numeric_limits<double>::infinity();
    if (result.collapsed) l = equal;
  }
  return result;
}

/// (Σw)² / Σw²: how many particles of equal weight say as much (Liu 1996). Between 1 and the size
/// of the set; 0 where no weight is a number.
[[nodiscard]] inline double effective_sample_size(std::span<const double> log_weights) {
  const double max = max_log_weight(log_weights);
  if (!std::isfinite(max)) return 0.0;
  double sum = 0.0, squares = 0.0;
  for (const double l : log_weights) {
    const double w = relative_weight(l, max);
    sum += w;
    squares += w * w;
  }
  return sum * sum / squares;
}

/// How to draw n particles so that particle i, of normalised weight w, is expected n·w times. In
/// order of falling variance of that count:
enum class Resampling {
  multinomial,  ///< n independent draws: binomial, variance n·w(1 − w)
  residual,     ///< ⌊n·w⌋ times for certain, the rest by independent draws (Liu and Chen 1998)
  stratified,   ///< one draw in each n-th of the cumulated weight: within 2 of n·w (Kitagawa 1996)
  low_variance  ///< the same with one random offset for all: within 1 of n·w (Kitagawa 1996)
};

/// Draws `drawn.size()` particles; indices come in ascending order. Particles without weight are
/// never drawn, but where no weight is a number all have the same. An empty set gives zeros.
inline void resample(std::span<const double> log_weights, Resampling scheme, Rng& rng,
                     std::span<ParticleIndex> drawn);

/// The same as a new list of `count`.
[[nodiscard]] inline std::vector<ParticleIndex> resample(std::span<const double> log_weights,
                                                         std::size_t count, Resampling scheme,
                                                         Rng& rng) {
  std::vector<ParticleIndex> drawn(count);
  resample(log_weights, scheme, rng, drawn);
  return drawn;
}

namespace detail {

/// The next of n thresholds in ascending order in [0, 1).
class AscendingThresholds {
 public:
  AscendingThresholds(Resampling scheme, std::size_t n, Rng& rng)
      : scheme_(scheme), n_(n), rng_(rng), offset_(rng.uniform()) {}

  double next() {
    const auto i = static_cast<double>(i_++), n = static_cast<double>(n_);
    if (scheme_ == Resampling::low_variance) return (i + offset_) / n;
    if (scheme_ == Resampling::stratified) return (i + rng_.uniform()) / n;
    // The smallest of the n - i uniform numbers still to come, between the last one and 1.
    above_ *= std::pow(1.0 - rng_.uniform(), 1.0 / (n - i));
    return 1.0 - above_;
  }

 private:
  Resampling scheme_;
  std::size_t n_, i_ = 0;
  Rng& rng_;
  double offset_, above_ = 1.0;
};

}  // namespace detail

inline void resample(std::span<const double> log_weights, Resampling scheme, Rng& rng,
                     std::span<ParticleIndex> drawn) {
  const double max = max_log_weight(log_weights);
  const bool collapsed = !std::isfinite(max);
  const auto weight = [&](std::size_t i) {
    return collapsed ? 1.0 : relative_weight(log_weights[i], max);
  };
  const auto n = static_cast<double>(drawn.size());
  double sum = 0.0;
  for (std::size_t i = 0; i < log_weights.size(); ++i) sum += weight(i);

  // What is left to chance: everything, or the fractions of the expected counts.
  const bool residual = scheme == Resampling::residual;
  const auto certain = [&](double w) { return residual ? std::floor(n * w / sum) : 0.0; };
  std::size_t left = drawn.size();
  double chance_sum = 0.0;
  for (std::size_t i = 0; i < log_weights.size(); ++i) {
    const double sure = certain(weight(i));
    left -= std::min(left, static_cast<std::size_t>(sure));
    chance_sum += n * weight(i) / sum - sure;
  }

  detail::AscendingThresholds thresholds(scheme, left, rng);
  double next = left > 0 ? thresholds.next() * chance_sum : 0.0, cumulated = 0.0;
  std::size_t at = 0;
  ParticleIndex last_with_chance = 0;
  const auto draw = [&](ParticleIndex i) { drawn[at++] = i; };
  for (ParticleIndex i = 0; i < log_weights.size(); ++i) {
    const double expected = n * weight(i) / sum, sure = certain(weight(i));
    for (double k = 0.0; k < sure && at < drawn.size(); ++k) draw(i);
    if (!(expected - sure > 0.0)) continue;
    cumulated += expected - sure;
    last_with_chance = i;
    while (left > 0 && next < cumulated) {
      draw(i);
      if (--left > 0) next = thresholds.next() * chance_sum;
    }
  }
  while (at < drawn.size()) draw(last_with_chance);  // thresholds lost to rounding at the very end
}

}  // namespace wayfare
