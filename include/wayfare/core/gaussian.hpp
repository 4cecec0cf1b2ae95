#pragma once

// Gaussians on manifolds: a mean and a covariance in its tangent space, composed and multiplied.

#include <cmath>
#include <numbers>

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include <wayfare/core/manifold.hpp>
#include <wayfare/core/random.hpp>
#include <wayfare/core/result.hpp>

namespace wayfare {

/// x = mean ⊞ τ with τ ~ N(0, covariance); units are those of the manifold's tangent.
template <Manifold M>
struct Gaussian {
  using Tangent = TangentOf<M>;                       ///< a difference to the mean
  using Covariance = SquareOf<M>;                     ///< of such differences
  using Scalar = typename ManifoldTraits<M>::Scalar;  ///< floating point

  M mean = manifold_origin<M>();                   ///< a point of the manifold
  Covariance covariance = Covariance::Identity();  ///< of τ
};

/// Whether a square matrix is finite, symmetric and positive semi-definite, the latter two to 1e-6
/// of the correlations, so that the units of its rows do not matter. Standard deviations below 1e-6
/// of the largest count as that.
template <class Derived>
[[nodiscard]] bool is_positive_semidefinite(const Eigen::MatrixBase<Derived>& matrix) {
  constexpr double kRounding = 1e-6, kLeast = 1e-150;  // whose inverse square does not overflow
  using Square = Eigen::Matrix<double, Derived::RowsAtCompileTime, Derived::ColsAtCompileTime>;
  // Of other scalars a cast is an expression.
  // NOLINTNEXTLINE(performance-unnecessary-copy-initialization)
  const Square m = matrix.template cast<double>();
  if (!m.allFinite() || (m.diagonal().array() < 0).any()) return false;
  const auto sigma = m.diagonal().cwiseSqrt().eval();
  const auto scale =
      sigma.cwiseMax(kRounding * sigma.maxCoeff()).cwiseMax(kLeast).cwiseInverse().eval();
  Square r = scale.asDiagonal() * m * scale.asDiagonal();
  if (!((r - r.transpose()).array().abs() <= kRounding).all()) return false;
  r.diagonal().array() += kRounding;
  return Eigen::LLT<Square>(r).info() == Eigen::Success;
}

/// The same, and no direction is known exactly: the Cholesky factorisation exists.
template <class Derived>
[[nodiscard]] bool is_positive_definite(const Eigen::MatrixBase<Derived>& matrix) {
  return is_positive_semidefinite(matrix) &&
         Eigen::LLT<typename Derived::PlainObject>(matrix).info() == Eigen::Success;
}

/// (x ⊟ mean)ᵀ Σ⁻¹ (x ⊟ mean); NaN where the covariance is not positive definite.
template <Manifold M>
[[nodiscard]] auto squared_mahalanobis(const Gaussian<M>& g, const M& x) {
  using Scalar = typename Gaussian<M>::Scalar;
  const Eigen::LLT<SquareOf<M>> llt(g.covariance);
  if (llt.info() != Eigen::Success) return Scalar(NAN);
  return Scalar(llt.matrixL().solve(ManifoldTraits<M>::minus(x, g.mean)).squaredNorm());
}

/// ln of the density at `x`: −½(d² + n ln 2π + ln|Σ|).
template <Manifold M>
[[nodiscard]] auto log_density(const Gaussian<M>& g, const M& x) {
  using std::log;
  using Scalar = typename Gaussian<M>::Scalar;
  const Eigen::LLT<SquareOf<M>> llt(g.covariance);
  if (llt.info() != Eigen::Success) return Scalar(NAN);
  const auto whitened = llt.matrixL().solve(ManifoldTraits<M>::minus(x, g.mean)).eval();
  const Scalar log_root_det = llt.matrixLLT().diagonal().array().log().sum();
  constexpr double kHalfLog2Pi = 0.91893853320467274178;
  return Scalar(Scalar(-0.5) * whitened.squaredNorm() - log_root_det -
                Scalar(ManifoldTraits<M>::kDof * kHalfLog2Pi));
}

/// Draws a sample; the covariance may be singular, e.g. of a robot that cannot slip.
template <Manifold M>
[[nodiscard]] M sample(const Gaussian<M>& g, Rng& rng) {
  using Scalar = typename Gaussian<M>::Scalar;
  TangentOf<M> white;
  for (auto& w : white) w = Scalar(rng.normal());
  const Eigen::LDLT<SquareOf<M>> ldlt(g.covariance);
  const TangentOf<M> scaled = ldlt.vectorD().cwiseMax(Scalar(0)).cwiseSqrt().cwiseProduct(white);
  const TangentOf<M> tau =
      ldlt.transpositionsP().transpose() * TangentOf<M>(ldlt.matrixL() * scaled);
  return ManifoldTraits<M>::plus(g.mean, tau);
}

/// The normalised product of two densities on the same manifold:
/// Σ = (Σ₁⁻¹ + Σ₂⁻¹)⁻¹, mean = mean₁ ⊞ Σ Σ₂⁻¹ (mean₂ ⊟ mean₁). The difference is taken on the
/// manifold, so headings wrap; exact for vectors, first order for curved groups. Errors: a sum of
/// covariances that is not positive definite, numbers that are not finite.
template <Manifold M>
[[nodiscard]] Result<Gaussian<M>> product(const Gaussian<M>& a, const Gaussian<M>& b) {
  using Scalar = typename Gaussian<M>::Scalar;
  const Eigen::LLT<SquareOf<M>> sum(a.covariance + b.covariance);
  if (sum.info() != Eigen::Success || !sum.matrixLLT().allFinite()) {
    return Error{ErrorCode::numerical, "the sum of the two covariances is not positive definite"};
  }
  const SquareOf<M> gain = sum.solve(a.covariance).transpose();  // Σ₁ (Σ₁ + Σ₂)⁻¹
  const SquareOf<M> covariance = gain * b.covariance;
  const TangentOf<M> correction = gain * ManifoldTraits<M>::minus(b.mean, a.mean);
  if (!correction.allFinite() || !covariance.allFinite())
    return Error{ErrorCode::numerical, "a mean or covariance is not finite"};
  return Gaussian<M>{ManifoldTraits<M>::plus(a.mean, correction),
                     SquareOf<M>(Scalar(0.5) * (covariance + covariance.transpose()))};
}

/// The pose a ∘ b of two independent uncertain poses: Σ = Ad(b⁻¹) Σa Ad(b⁻¹)ᵀ + Σb.
template <LieGroup G>
[[nodiscard]] Gaussian<G> compose(const Gaussian<G>& a, const Gaussian<G>& b) {
  const SquareOf<G> adjoint = b.mean.inverse().adjoint();
  return {a.mean * b.mean,
          SquareOf<G>(adjoint * a.covariance * adjoint.transpose() + b.covariance)};
}

}  // namespace wayfare
