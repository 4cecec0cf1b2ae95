#pragma once

#include <Eigen/Core>

#include <wayfare/core/manifold.hpp>

namespace wayfare::tests {

/// ∂f(x ⊞ τ)/∂τ at τ = 0 by central differences, `step` one per direction.
template <class M, class F>
auto numeric_gradient(const F& f, const M& x, const TangentOf<M>& step) {
  Eigen::Matrix<double, 1, ManifoldTraits<M>::kDof> row;
  for (int i = 0; i < row.size(); ++i) {
    const TangentOf<M> tau = step[i] * TangentOf<M>::Unit(i);
    row[i] = (f(ManifoldTraits<M>::plus(x, tau)) - f(ManifoldTraits<M>::plus(x, -tau))) /
             (2.0 * step[i]);
  }
  return row;
}

/// ∂(f(x ⊞ τ) ⊟ f(x))/∂τ.
template <class M, class F>
SquareOf<M> numeric_jacobian(const F& f, const M& x, const TangentOf<M>& step) {
  using Traits = ManifoldTraits<M>;
  SquareOf<M> j;
  for (int i = 0; i < Traits::kDof; ++i) {
    const TangentOf<M> tau = step[i] * TangentOf<M>::Unit(i);
    j.col(i) = Traits::minus(f(Traits::plus(x, tau)), f(Traits::plus(x, -tau))) / (2.0 * step[i]);
  }
  return j;
}

}  // namespace wayfare::tests
