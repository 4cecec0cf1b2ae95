#pragma once

// What a process of a filter is.

#include <concepts>

#include <wayfare/core/manifold.hpp>

namespace wayfare {

/// x ← f(x, u), P ← Φ P Φᵀ + Q. A process returns its step: `state`, and either `phi` and `q`
/// (square matrices of the tangent's size) or, to avoid the dense product, a member `propagate(P)`
/// that propagates the covariance (symmetric, both triangles) itself.
template <class Step, class M>
concept DenseProcessStep = requires(const Step& s) {
  { s.state } -> std::convertible_to<M>;
  { s.phi } -> std::convertible_to<SquareOf<M>>;
  { s.q } -> std::convertible_to<SquareOf<M>>;
};
template <class Step, class M>
concept SparseProcessStep = requires(const Step& s, SquareOf<M>& p) {
  { s.state } -> std::convertible_to<M>;
  s.propagate(p);
};
template <class F, class M, class... Input>
concept ProcessModel = requires(const F& f, const M& x, const Input&... u) {
  requires DenseProcessStep<decltype(f(x, u...)), M> || SparseProcessStep<decltype(f(x, u...)), M>;
};

}  // namespace wayfare
