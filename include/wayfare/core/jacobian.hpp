#pragma once

// Jacobians of functions between manifolds, for the right perturbations x ⊞ δ of their arguments.
// Edges, measurements and couplings of states choose the kind by type.

#include <array>
#include <concepts>
#include <cstddef>
#include <tuple>
#include <utility>

#include <Eigen/Core>

#include <wayfare/core/dual.hpp>
#include <wayfare/core/manifold.hpp>

namespace wayfare {

/// How Jacobians are computed where a type does not give them itself.
struct NumericJacobians {};    ///< central differences: lose a third of the digits
struct AutomaticJacobians {};  ///< the function evaluated on dual numbers: exact to rounding

/// ∂y/∂δᵢ of y ∈ Y by each argument.
template <class Y, class... V>
using JacobianBlocks =
    std::tuple<Eigen::Matrix<double, ManifoldTraits<Y>::kDof, ManifoldTraits<V>::kDof>...>;

namespace detail {

template <class F>
inline constexpr bool kIsAutomatic = requires {
  requires std::same_as<typename F::Jacobians, AutomaticJacobians>;
};

/// Jacobians of the same function as one matrix.
template <int Rows, int... Cols>
[[nodiscard]] auto side_by_side(const std::tuple<Eigen::Matrix<double, Rows, Cols>...>& blocks) {
  Eigen::Matrix<double, Rows, (Cols + ...)> all;
  int at = 0;
  const auto append = [&](const auto& block, int count) {
    for (int j = 0; j < count; ++j, ++at)
      for (int i = 0; i < Rows; ++i) all(i, at) = block(i, j);
  };
  std::apply([&](const auto&... block) { (append(block, Cols), ...); }, blocks);
  return all;
}

/// x ⊞ δ on dual numbers; δ are the variables from `first` on.
template <int N, Manifold V>
auto on_duals(const V& x, int first) {
  using D = Dual<double, N>;
  constexpr int kDof = ManifoldTraits<V>::kDof;
  Eigen::Matrix<D, kDof, 1> step;
  for (int i = 0; i < kDof; ++i) step[i] = D::variable(0.0, first + i);
  if constexpr (requires { x.template cast<D>().plus(step); }) {
    return x.template cast<D>().plus(step);
  } else {
    return Eigen::Matrix<D, kDof, 1>(x.template cast<D>() + step);
  }
}

template <class Y, class F, class... V, std::size_t... I>
Y differentiate_automatically(const F& f, JacobianBlocks<Y, V...>& by, std::index_sequence<I...>,
                              const V&... x) {
  constexpr std::array<int, sizeof...(V)> kDofs{ManifoldTraits<V>::kDof...};
  constexpr int kAll = (ManifoldTraits<V>::kDof + ...);
  constexpr auto kFirst = [&] {
    std::array<int, sizeof...(V)> first{};
    for (std::size_t i = 1; i < first.size(); ++i) first[i] = first[i - 1] + kDofs[i - 1];
    return first;
  }();
  const auto y = f(on_duals<kAll>(x, kFirst[I])...);
  const auto scatter = [&](const auto& tangent) {
    for (int row = 0; row < ManifoldTraits<Y>::kDof; ++row)
      ((std::get<I>(by).row(row) =
            tangent[row].derivatives.template segment<kDofs[I]>(kFirst[I]).transpose()),
       ...);
  };
  if constexpr (requires(const Y& at) { y.minus(at.template cast<Dual<double, kAll>>()); }) {
    const Y at = f(x...);
    scatter(y.minus(at.template cast<Dual<double, kAll>>()));
    return at;
  } else {
    scatter(y);
    Y values;
    for (int row = 0; row < ManifoldTraits<Y>::kDof; ++row) values[row] = y[row].value;
    return values;
  }
}

/// The column of differences along each direction of argument I.
template <std::size_t I, class Y, class F, class... V>
void differentiate_numerically(const F& f, JacobianBlocks<Y, V...>& by, std::tuple<V...> x) {
  using X = std::tuple_element_t<I, std::tuple<V...>>;
  using Traits = ManifoldTraits<X>;
  constexpr double kStep = 6e-6;  // about ε^⅓: balances truncation and rounding
  const X at = std::get<I>(x);
  const auto value = [&](const auto&... each) { return Y(f(each...)); };
  for (int k = 0; k < Traits::kDof; ++k) {
    TangentOf<X> step = TangentOf<X>::Zero();
    step[k] = kStep;
    std::get<I>(x) = Traits::plus(at, step);
    const Y ahead = std::apply(value, x);
    std::get<I>(x) = Traits::plus(at, TangentOf<X>(-step));
    std::get<I>(by).col(k) = ManifoldTraits<Y>::minus(ahead, std::apply(value, x)) / (2.0 * kStep);
  }
}

}  // namespace detail

/// y = f(x...) and its Jacobians, automatic or numeric as the type `Choice` says (see Edge).
template <class Choice, class Y, class F, class... V>
Y differentiate(const F& f, JacobianBlocks<Y, V...>& by, const V&... x) {
  if constexpr (detail::kIsAutomatic<Choice>) {
    return detail::differentiate_automatically<Y>(f, by, std::index_sequence_for<V...>{}, x...);
  } else {
    [&]<std::size_t... I>(std::index_sequence<I...>) {
      (detail::differentiate_numerically<I, Y>(f, by, std::tuple<V...>(x...)), ...);
    }
    (std::index_sequence_for<V...>{});
    return f(x...);
  }
}

}  // namespace wayfare
