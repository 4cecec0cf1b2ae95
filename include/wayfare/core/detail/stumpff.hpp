#pragma once

#include <cmath>
#include <type_traits>

#include <wayfare/core/pack.hpp>

namespace wayfare {

namespace detail {

constexpr double factorial(int n) {
  double product = 1.0;
  for (int i = 2; i <= n; ++i) product *= i;
  return product;
}

/// For x < 0.25.
template <int N, class T>
[[nodiscard]] T stumpff_series(const T& x) {
  constexpr int kTerms = 8;  // the first neglected term is below 0.25⁸/16! = 7e-19
  T sum = T(1.0 / factorial(N + 2 * (kTerms - 1)));
  for (int k = kTerms - 2; k >= 0; --k) sum = T(1.0 / factorial(N + 2 * k)) - x * sum;
  return sum;
}

}  // namespace detail

/// The Stumpff function cₙ(x) = Σₖ (−x)ᵏ / (n + 2k)!, x = θ² ≥ 0. They are the coefficients of the
/// exponential maps and Jacobians of the rotation groups:
///   c₀ = cos θ, c₁ = sin θ/θ, c₂ = (1 − cos θ)/θ², c₃ = (θ − sin θ)/θ³, …
/// Near zero these quotients lose all digits, in single precision already at θ = 0.1.
template <int N, class T>
[[nodiscard]] T stumpff(const T& x) {
  using std::cos, std::sin, std::sqrt;
  static_assert(N >= 0);
  const auto near = x < T(0.25);
  if (all(near)) return detail::stumpff_series<N>(x);
  T closed;
  if constexpr (N == 0) {
    closed = cos(sqrt(x));
  } else if constexpr (N == 1) {
    const T angle = sqrt(x);
    closed = sin(angle) / angle;
  } else {
    closed = (T(1.0 / detail::factorial(N - 2)) - stumpff<N - 2>(x)) / x;
  }
  if constexpr (std::is_same_v<decltype(near), const bool>) {
    return closed;
  } else {
    return select(near, detail::stumpff_series<N>(x), closed);
  }
}

}  // namespace wayfare
