#pragma once

// What an edge of a factor graph is: an error on one or more variables, with its Jacobians. Edges
// are plain values; any type with these members is one.
//
//   struct RangeToBeacon {                       // to a beacon at an unknown place
//     using Variables = EdgeVariables<SE2d, Eigen::Vector2d>;
//     using Jacobians = AutomaticJacobians;
//     static constexpr int kDim = 1;
//     double range_m, sigma_m;
//     template <class T>
//     Eigen::Matrix<T, 1, 1> error(const SE2<T>& x, const Eigen::Matrix<T, 2, 1>& beacon) const {
//       using std::sqrt;
//       return Eigen::Matrix<T, 1, 1>(((beacon - x.translation()).norm() - range_m) / sigma_m);
//     }
//   };

#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <tuple>
#include <utility>

#include <Eigen/Core>

#include <wayfare/core/detail/eigen_alignment.hpp>
#include <wayfare/core/jacobian.hpp>
#include <wayfare/core/manifold.hpp>
#include <wayfare/graph/robust_kernel.hpp>

namespace wayfare {

/// The types of an edge's variables, in the order of its error's arguments.
template <Manifold... V>
struct EdgeVariables {
  static constexpr std::size_t kCount = sizeof...(V);  ///< number of variables
};

/// ∂e/∂δᵢ for the right perturbation x_i ⊞ δ_i of each variable.
template <int Dim, class Variables>
struct EdgeJacobians;
/// Of an edge on these variables.
template <int Dim, class... V>
struct EdgeJacobians<Dim, EdgeVariables<V...>> {
  /// One kDim × kDof block for each variable.
  JacobianBlocks<Eigen::Matrix<double, Dim, 1>, V...> by;
};

/// Jacobians of an edge type.
template <class E>
using JacobiansOf = EdgeJacobians<E::kDim, typename E::Variables>;

/// Error of an edge type.
template <class E>
using EdgeError = Eigen::Matrix<double, E::kDim, 1>;

namespace detail {

template <class E, class Variables>
struct EdgeTraits : std::false_type {};
template <class E, class... V>
struct EdgeTraits<E, EdgeVariables<V...>> {
  static constexpr bool kHasMemberError = requires(const E& edge, const V&... x) {
    { edge.error(x...) } -> std::convertible_to<EdgeError<E>>;
  };
  static constexpr bool kIsAnalytic = requires(const E& edge, const V&... x, JacobiansOf<E>& j) {
    { edge.linearise(x..., j) } -> std::convertible_to<EdgeError<E>>;
  };
};

template <class E>
inline constexpr bool kHasInformation = requires(const E& edge) {
  { edge.information } -> std::convertible_to<Eigen::Matrix<double, E::kDim, E::kDim>>;
};
template <class E>
inline constexpr bool kHasKernel = requires(const E& edge) {
  { edge.kernel(1.0) } -> std::convertible_to<KernelValue>;
};

}  // namespace detail

/// Required: `Variables`, `kDim`, and `error(x...)`, a vector of kDim numbers. Optional:
/// - `linearise(x..., JacobiansOf<E>&)`, which returns the error and sets the Jacobians; else
/// - `using Jacobians = AutomaticJacobians`, where `error` is a template of the scalar; else they
///   are numeric;
/// - `information`, Ω of the error; without it the error is in standard deviations;
/// - `kernel`, called with eᵀΩe, which returns the cost and weight (KernelValue).
template <class E>
concept Edge = std::copyable<E> && requires {
  typename E::Variables;
  { E::kDim } -> std::convertible_to<int>;
} && detail::EdgeTraits<E, typename E::Variables>::kHasMemberError;

namespace detail {

/// What a type lacks to be an edge, in words.
template <class E>
consteval bool check_edge() {
  constexpr bool kNamesVariables = requires { typename E::Variables; };
  constexpr bool kHasDimension = requires {
    { E::kDim } -> std::convertible_to<int>;
  };
  static_assert(kNamesVariables,
                "wayfare: an edge names its variables, using Variables = EdgeVariables<X, Y>");
  static_assert(kHasDimension,
                "wayfare: an edge has the size of its error, static constexpr int kDim");
  if constexpr (kNamesVariables && kHasDimension)
    static_assert(EdgeTraits<E, typename E::Variables>::kHasMemberError,
                  "wayfare: an edge has a const member error(x, y), which takes its variables and "
                  "returns Eigen::Matrix<double, kDim, 1>");
  static_assert(std::copyable<E>, "wayfare: an edge is a value: it can be copied and assigned");
  if constexpr (requires { &E::kernel; })
    static_assert(kHasKernel<E>,
                  "wayfare: the kernel of an edge is called with a double and returns a "
                  "KernelValue");
  return true;
}

}  // namespace detail

/// An edge whose loss is a KernelFunction.
template <Edge E, class Kernel = RobustKernel>
struct Robust : E {
  static_assert(detail::check_kernel<Kernel>());
  Kernel kernel;  ///< its loss
};
/// The types are those of its members.
template <class E, class K>
Robust(E, K) -> Robust<E, K>;

/// The error of an edge and its Jacobians, by the means the edge chose.
template <Edge E, class... V>
EdgeError<E> linearise(const E& edge, JacobiansOf<E>& j, const V&... x) {
  if constexpr (detail::EdgeTraits<E, typename E::Variables>::kIsAnalytic) {
    return edge.linearise(x..., j);
  } else {
    const auto error = [&edge](const auto&... each) { return edge.error(each...); };
    return differentiate<E, EdgeError<E>>(error, j.by, x...);
  }
}

/// eᵀΩe of an edge.
template <Edge E, class... V>
[[nodiscard]] double squared_error(const E& edge, const V&... x) {
  const EdgeError<E> e = edge.error(x...);
  if constexpr (detail::kHasInformation<E>)
    return not_negative(e.dot(edge.information * e));
  else
    return e.squaredNorm();
}

/// ρ(s) and ρ′(s) of an edge with eᵀΩe = s.
template <Edge E>
[[nodiscard]] KernelValue robust_value(const E& edge, double s) {
  if constexpr (detail::kHasKernel<E>)
    return edge.kernel(s);
  else
    return {s, 1.0};
}

}  // namespace wayfare
