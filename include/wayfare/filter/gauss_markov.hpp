#pragma once

// Random processes, discretised exactly: over a step, n ← φ n + N(0, q).

#include <cmath>

#include <wayfare/core/pack.hpp>

namespace wayfare {

/// A step of a process of one number: n ← φ n + noise.
template <class T>
struct ProcessStep1 {
  T phi;  ///< transition factor
  T q;    ///< variance of the added noise
};

namespace detail {
/// 1 − e^(−x), x ≥ 0, to full relative precision for small x.
template <class T>
[[nodiscard]] T one_minus_exp_of_minus(const T& x) {
  using std::exp;
  // Horner's form of the series; the first neglected term is below 0.03¹⁰/11! = 1e-23 of the sum.
  T sum = T(1);
  for (int k = 10; k >= 2; --k) sum = T(1) - x * sum / T(k);
  const T series = x * sum;
  const MaskOf<T> small = x < T(0.03);
  if (all(small)) return series;
  return select(small, series, T(1) - exp(-x));
}
}  // namespace detail

/// ṅ = −n/τ + √(2σ²/τ) w over `dt_s`: φ = e^(−dt/τ), q = σ²(1 − e^(−2dt/τ)) (Gelb 1974, (4.4-5)).
template <class T>
[[nodiscard]] ProcessStep1<T> discretise_gauss_markov(const T& sigma, const T& tau_s,
                                                      const T& dt_s) {
  const T decay = detail::one_minus_exp_of_minus(T(dt_s / tau_s));
  return {T(1) - decay, sigma * sigma * decay * (T(2) - decay)};
}

/// Noise added to a receiver clock over a step.
template <class T>
struct ClockStep {
  T bias_variance,     ///< m²
      covariance,      ///< of bias and drift, m²/s
      drift_variance;  ///< (m/s)²
};
/// A receiver clock over `dt_s`: bias and drift as random walks, the drift integrated into the
/// bias (Brown and Hwang 1997, section 10.3).
template <class T>
[[nodiscard]] ClockStep<T> discretise_clock(const T& bias_walk, const T& drift_walk,
                                            const T& dt_s) {
  const T drift = drift_walk * drift_walk * dt_s;
  return {bias_walk * bias_walk * dt_s + drift * dt_s * dt_s / T(3), drift * dt_s / T(2), drift};
}

}  // namespace wayfare
