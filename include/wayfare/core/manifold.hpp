#pragma once

// What estimators, factor graphs and Gaussians require of a state: a point that can be perturbed by
// a tangent vector.
//
// Conventions throughout: right perturbation (x ⊞ τ = x ∘ exp τ), translation first in a tangent
// vector. Equation numbers: Solà, Deray, Atchuthan, "A micro Lie theory for state estimation in
// robotics", arXiv:1812.01537.

#include <concepts>
#include <type_traits>

#include <Eigen/Core>

namespace wayfare {

/// Plus and minus of a type. The Lie groups provide the members themselves; fixed-size Eigen column
/// vectors are covered below; specialise it for your own type.
template <class M>
struct ManifoldTraits {
  using Scalar = typename M::Scalar;               ///< floating point, a SIMD pack or a dual number
  static constexpr int kDof = M::kDof;             ///< dimension of the tangent space
  using Tangent = Eigen::Matrix<Scalar, kDof, 1>;  ///< an increment
  /// x ⊞ τ.
  static M plus(const M& x, const Tangent& tau) { return x.plus(tau); }
  /// y ⊟ x, with x ⊞ (y ⊟ x) = y.
  static Tangent minus(const M& y, const M& x) { return y.minus(x); }
};

/// A vector space.
template <class T, int N>
struct ManifoldTraits<Eigen::Matrix<T, N, 1>> {
  static_assert(N > 0, "wayfare: a manifold's dimension is fixed at compile time");
  using Scalar = T;                        ///< of the elements
  static constexpr int kDof = N;           ///< number of elements
  using Tangent = Eigen::Matrix<T, N, 1>;  ///< a vector
  /// x + τ.
  static Tangent plus(const Tangent& x, const Tangent& tau) { return x + tau; }
  /// y − x.
  static Tangent minus(const Tangent& y, const Tangent& x) { return y - x; }
};

/// Laws (checked by testing/lie_group_laws.hpp): x ⊞ 0 = x, x ⊞ (y ⊟ x) = y, (x ⊞ τ) ⊟ x = τ near
/// zero.
template <class M>
concept Manifold = requires(const M& x, const M& y,
                            const typename ManifoldTraits<M>::Tangent& tau) {
  typename ManifoldTraits<M>::Scalar;
  { ManifoldTraits<M>::kDof } -> std::convertible_to<int>;
  { ManifoldTraits<M>::plus(x, tau) } -> std::convertible_to<M>;
  { ManifoldTraits<M>::minus(y, x) } -> std::convertible_to<typename ManifoldTraits<M>::Tangent>;
};

/// The identity of a group, zero of a vector space, else the default value. (Eigen's own default
/// value is uninitialised.)
template <class M>
[[nodiscard]] M manifold_origin() {
  if constexpr (requires { M::identity(); }) {
    return M::identity();
  } else if constexpr (requires { M::Zero(); }) {
    return M::Zero();
  } else {
    return M{};
  }
}

/// Tangent vector of a manifold, kDof × 1.
template <class M>
using TangentOf = typename ManifoldTraits<M>::Tangent;

/// Square matrix of its tangent space, kDof × kDof, such as a covariance.
template <class M>
using SquareOf = Eigen::Matrix<typename ManifoldTraits<M>::Scalar, ManifoldTraits<M>::kDof,
                               ManifoldTraits<M>::kDof>;

/// A manifold that is also a group, with its exponential map and Jacobians.
template <class G>
concept LieGroup = Manifold<G> && requires(const G& x, const G& y, const TangentOf<G>& tau) {
  { G::identity() } -> std::same_as<G>;
  { x.inverse() } -> std::same_as<G>;
  { x* y } -> std::same_as<G>;
  { G::exp(tau) } -> std::same_as<G>;
  { x.log() } -> std::convertible_to<TangentOf<G>>;
  { x.adjoint() } -> std::convertible_to<SquareOf<G>>;
  { G::right_jacobian(tau) } -> std::convertible_to<SquareOf<G>>;
  { G::right_jacobian_inverse(tau) } -> std::convertible_to<SquareOf<G>>;
};

}  // namespace wayfare
