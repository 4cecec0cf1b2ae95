#pragma once

// Robust kernels: losses that reduce the influence of large residuals.

#include <cmath>
#include <concepts>

namespace wayfare {

/// A kernel replaces s = eᵀΩe by ρ(s), with ρ(s) ≈ s for small s. `scale` is the residual √s, in
/// standard deviations, at which ρ departs from s.
enum class RobustKernelKind {
  none,           ///< ρ = s
  huber,          ///< ρ = s up to scale², then 2·scale·√s − scale²: convex
  cauchy,         ///< ρ = scale² ln(1 + s/scale²)
  geman_mcclure,  ///< ρ = s·scale²/(scale² + s): bounded by scale²
  /// Dynamic covariance scaling (Agarwal et al. 2013), Φ = scale²: ρ = s while s ≤ Φ, then
  /// 3Φ − 4Φ²/(Φ + s): the loss whose weight is the paper's squared switch variable (2Φ/(Φ + s))²,
  /// which is never negative.
  dynamic_covariance_scaling,
};

/// ρ(s) and ρ′(s).
struct KernelValue {
  double cost = 0.0;  ///< ρ(s)
  /// ρ′(s) ∈ (0, 1]: the weight of the information matrix. The Hessian uses only this term (no
  /// Triggs correction), so it is positive semi-definite for every kernel.
  double weight = 1.0;
};

/// A robust kernel of any type: called with s = eᵀΩe ≥ 0, it returns ρ(s) and ρ′(s), with ρ(0) = 0,
/// ρ′(0) = 1 and ρ′ ≥ 0 not increasing (testing::KernelLaws).
template <class K>
concept KernelFunction = std::copyable<K> && requires(const K& kernel, double s) {
  { kernel(s) } -> std::convertible_to<KernelValue>;
};

namespace detail {

/// What a type lacks to be a robust kernel, in words.
template <class K>
consteval bool check_kernel() {
  static_assert(std::copyable<K>, "wayfare: a robust kernel is a value: it can be copied");
  static_assert(KernelFunction<K>,
                "wayfare: a robust kernel has a const member operator()(double s), which returns "
                "KernelValue{rho(s), rho'(s)}");
  return true;
}

}  // namespace detail

/// A kernel of the library, chosen at run time.
struct RobustKernel {
  RobustKernelKind kind = RobustKernelKind::none;  ///< loss of outliers
  double scale = 1.0;  ///< standard deviations, > 0; larger: less robust, infinite: none

  /// `s` = eᵀΩe ≥ 0.
  [[nodiscard]] KernelValue operator()(double s) const {
    const double width = scale * scale;
    switch (std::isinf(width) ? RobustKernelKind::none : kind) {
      case RobustKernelKind::none:
        break;
      case RobustKernelKind::huber: {
        if (s <= width) break;
        const double root = std::sqrt(s);
        return {2.0 * scale * root - width, scale / root};
      }
      case RobustKernelKind::cauchy:
        return {width * std::log1p(s / width), width / (width + s)};
      case RobustKernelKind::geman_mcclure: {
        const double k = width / (width + s);
        return {s * k, k * k};
      }
      case RobustKernelKind::dynamic_covariance_scaling: {
        if (s <= width) break;
        const double k = 2.0 * width / (width + s);
        return {width * (3.0 - 2.0 * k), k * k};
      }
    }
    return {s, 1.0};
  }
};

/// eᵀΩe as computed, without what rounding may have taken below zero: Ω is positive semi-definite,
/// so that zero is nearer to the truth than any negative number. NaN stays.
[[nodiscard]] inline double not_negative(double square) { return square < 0.0 ? 0.0 : square; }

}  // namespace wayfare
