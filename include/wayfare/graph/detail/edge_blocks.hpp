#pragma once

#include <cstddef>
#include <type_traits>
#include <utility>

#include <Eigen/Core>

#include <wayfare/graph/edge.hpp>

namespace wayfare::detail {

struct EdgeCost {
  double squared_error;  ///< s = eᵀΩe
  double cost;           ///< ρ(s)
};

/// The part of an edge in H and g at x: to_gradient(i, w JᵢᵀΩe) for each variable i, followed by
/// to_hessian(i, j, w JᵢᵀΩJⱼ), an expression, for each j ≥ i. w is `weight` times ρ′(s), ρ(s) = s
/// unless `kernels`; i and j are integral constants.
template <Edge E, class ToGradient, class ToHessian, class... X>
EdgeCost edge_blocks(const E& edge, double weight, bool kernels, const ToGradient& to_gradient,
                     const ToHessian& to_hessian, const X&... x) {
  JacobiansOf<E> jacobians;
  const EdgeError<E> e = wayfare::linearise(edge, jacobians, x...);
  EdgeError<E> f = e;  // Ωe
  if constexpr (kHasInformation<E>) f = edge.information * e;
  const double s = not_negative(e.dot(f));
  const KernelValue rho = kernels ? robust_value(edge, s) : KernelValue{s, 1.0};
  const double w = rho.weight * weight;
  const auto with_row = [&]<std::size_t I>(std::integral_constant<std::size_t, I> row) {
    const auto& ji = std::get<I>(jacobians.by);
    constexpr int kRows = std::remove_cvref_t<decltype(ji)>::ColsAtCompileTime;
    const Eigen::Matrix<double, kRows, E::kDim> scaled = [&] {  // w Jᵢᵀ Ω
      using Scaled = Eigen::Matrix<double, kRows, E::kDim>;
      if constexpr (kHasInformation<E>)
        return Scaled(w * ji.transpose() * edge.information);
      else
        return Scaled(w * ji.transpose());
    }();
    to_gradient(row, Eigen::Matrix<double, kRows, 1>(w * (ji.transpose() * f)));
    [&]<std::size_t... J>(std::index_sequence<J...>) {
      (to_hessian(row, std::integral_constant<std::size_t, I + J>{},
                  scaled * std::get<I + J>(jacobians.by)),
       ...);
    }
    (std::make_index_sequence<sizeof...(X) - I>{});
  };
  [&]<std::size_t... I>(std::index_sequence<I...>) {
    (with_row(std::integral_constant<std::size_t, I>{}), ...);
  }
  (std::index_sequence_for<X...>{});
  return {s, rho.cost};
}

}  // namespace wayfare::detail
