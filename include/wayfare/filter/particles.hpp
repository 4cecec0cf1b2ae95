#pragma once

// Particle weights and resampling. Weights are logarithms and need not be normalised: the product
// of a few hundred likelihoods is below the smallest double.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include <wayfare/core/random.hpp>

namespace wayfare {

/// Index of a drawn particle in the set before resampling.
using ParticleIndex = std::uint32_t;

/// The largest valid weight, -inf where there is none. NaN and +inf are not valid: a likelihood
/// that could not be computed has no weight.
[[nodiscard]] inline double max_log_weight(std::span<const double> log_weights) {
  double best = -std::numeric_limits<double>::infinity();
  for (const double l : log_weights)
    if (l > best && l < std::numeric_limits<double>::infinity()) best = l;
  return best;
}

/// exp(log_weight − max), 0 for an invalid weight.
[[nodiscard]] inline double relative_weight(double log_weight, double max) {
  const double difference = log_weight - max;
  return difference <= 0.0 ? std::exp(difference) : 0.0;  // false for NaN and +inf
}

/// ln Σ exp lᵢ without overflow or underflow; -inf where no weight is valid.
[[nodiscard]] inline double log_sum_exp(std::span<const double> log_weights) {
  const double max = max_log_weight(log_weights);
  if (!std::isfinite(max)) return max;
  double sum = 0.0;
  for (const double l : log_weights) sum += relative_weight(l, max);
  return max + std::log(sum);
}

/// What became of weights that were normalised.
struct Normalisation {
  /// ln of the sum of the weights: the evidence of the measurement, where they were normalised
  /// before. -inf after a collapse.
  double log_sum = 0.0;
  std::size_t refused = 0;  ///< weights that were NaN or +inf, now zero
  /// All weights were zero or invalid and are now equal: the measurement is ignored.
  bool collapsed = false;
};

/// Normalises the weights to a sum of one.
inline Normalisation normalise(std::span<double> log_weights) {
  Normalisation result{log_sum_exp(log_weights), 0, false};
  result.collapsed = !std::isfinite(result.log_sum);
  // In the rounding of a larger sum the number of the particles that share it is lost.
  constexpr double kLarge = 1e9;
  if (!result.collapsed && std::abs(result.log_sum) > kLarge) {
    const double max = max_log_weight(log_weights), log_sum = result.log_sum;
    for (double& l : log_weights) l -= max;
    result = normalise(log_weights);
    result.log_sum = log_sum;
    return result;
  }
  const double equal = -std::log(static_cast<double>(log_weights.size()));
  for (double& l : log_weights) {
    const bool number = l < std::numeric_limits<double>::infinity();
    result.refused += number ? 0 : 1;
    l = number ? l - result.log_sum : -std::numeric_limits<double>::infinity();
    if (result.collapsed) l = equal;
  }
  return result;
}

/// The weights themselves, with a sum of one.
[[nodiscard]] inline std::vector<double> normalised_weights(std::span<const double> log_weights) {
  std::vector<double> weights(log_weights.begin(), log_weights.end());
  normalise(weights);
  for (double& w : weights) w = std::exp(w);
  return weights;
}

/// (Σw)² / Σw²: the equivalent number of particles of equal weight (Liu 1996). Between 1 and the
/// size of the set; 0 where no weight is valid.
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

/// Schemes to draw n particles with an expected count of n·w for normalised weight w, in order of
/// decreasing variance of that count:
enum class Resampling {
  multinomial,  ///< n independent draws: binomial, variance n·w(1 − w)
  residual,     ///< ⌊n·w⌋ copies, the rest by independent draws (Liu and Chen 1998)
  stratified,   ///< one draw per 1/n of the cumulative weight: within 2 of n·w (Kitagawa 1996)
  low_variance  ///< the same with a common random offset: within 1 of n·w (Kitagawa 1996)
};

namespace detail {

/// Sums of the first weights, relative to the largest; of equal ones where no weight is valid.
[[nodiscard]] inline std::vector<double> cumulated_weights(std::span<const double> log_weights) {
  const double max = max_log_weight(log_weights);
  std::vector<double> sums;
  sums.reserve(log_weights.size());
  double sum = 0.0;
  for (const double l : log_weights)
    sums.push_back(sum += std::isfinite(max) ? relative_weight(l, max) : 1.0);
  return sums;
}

/// The next of n thresholds in ascending order in [0, 1).
class AscendingThresholds {
 public:
  AscendingThresholds(Resampling scheme, std::size_t n, Rng& rng)
      : scheme_(scheme), n_(n), rng_(rng), offset_(rng.uniform()) {}

  double next() {
    const auto i = static_cast<double>(i_++), n = static_cast<double>(n_);
    if (scheme_ == Resampling::low_variance) return (i + offset_) / n;
    if (scheme_ == Resampling::stratified) return (i + rng_.uniform()) / n;
    // The smallest of the n - i remaining uniform numbers between the last one and 1.
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

/// Draws `drawn.size()` particles, indices in ascending order. Particles without weight are never
/// drawn; where no weight is valid, all are equal. An empty set gives zeros.
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

  // Drawn at random: everything, or the fractional parts of the expected counts.
  const bool residual = scheme == Resampling::residual;
  const auto certain_count = [&](double w) { return residual ? std::floor(n * w / sum) : 0.0; };
  std::size_t remaining = drawn.size();
  double random_sum = 0.0;
  for (std::size_t i = 0; i < log_weights.size(); ++i) {
    const double certain = certain_count(weight(i));
    remaining -= std::min(remaining, static_cast<std::size_t>(certain));
    random_sum += n * weight(i) / sum - certain;
  }

  detail::AscendingThresholds thresholds(scheme, remaining, rng);
  double next = remaining > 0 ? thresholds.next() * random_sum : 0.0, cumulative = 0.0;
  std::size_t at = 0;
  ParticleIndex last_candidate = 0;
  const auto draw = [&](ParticleIndex i) { drawn[at++] = i; };
  for (ParticleIndex i = 0; i < log_weights.size(); ++i) {
    const double expected = n * weight(i) / sum, certain = certain_count(weight(i));
    for (double k = 0.0; k < certain && at < drawn.size(); ++k) draw(i);
    if (!(expected - certain > 0.0)) continue;
    cumulative += expected - certain;
    last_candidate = i;
    while (remaining > 0 && next < cumulative) {
      draw(i);
      if (--remaining > 0) next = thresholds.next() * random_sum;
    }
  }
  while (at < drawn.size()) draw(last_candidate);  // thresholds lost to rounding at the end
}

/// The same, returning `count` indices.
[[nodiscard]] inline std::vector<ParticleIndex> resample(std::span<const double> log_weights,
                                                         std::size_t count, Resampling scheme,
                                                         Rng& rng) {
  std::vector<ParticleIndex> drawn(count);
  resample(log_weights, scheme, rng, drawn);
  return drawn;
}

}  // namespace wayfare
