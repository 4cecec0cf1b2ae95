#pragma once

// What a gate of a filter is: what becomes of a measurement, by its innovation.
//
//   struct NoEchoes {                                   // reflected ranges are only ever longer
//     bool operator()(const Innovation<double, 1>& i) const {
//       return i.value < 3.0 * std::sqrt(i.covariance);
//     }
//   };
//   filter.update(range, NoEchoes{});

#include <concepts>
#include <type_traits>

#include <Eigen/Core>

#include <wayfare/core/pack.hpp>

namespace wayfare {

/// The innovation z − h(x) of a measurement of `Dim` numbers; of one number, T instead of matrices.
template <class T, int Dim>
struct Innovation {
  static constexpr int kDim = Dim;                                  ///< numbers of the measurement
  std::conditional_t<Dim == 1, T, Eigen::Matrix<T, Dim, 1>> value;  ///< z − h(x)
  std::conditional_t<Dim == 1, T, Eigen::Matrix<T, Dim, Dim>> covariance;  ///< H P Hᵀ + R
  /// Normalised innovation squared; χ² with `Dim` degrees of freedom for a consistent filter.
  T nis;
};

/// A const callable that returns either whether the measurement is used (a bool; of packs a mask),
/// or its weight w, a T: the update is made with the covariance R/w, and a weight that is not
/// positive and finite rejects the measurement. Called with finite numbers, but for packs, whose
/// lanes are not all in use. See testing::GateLaws.
template <class G, class T, int Dim>
concept UpdateGate = requires(const G& gate, const Innovation<T, Dim>& innovation) {
  requires std::same_as<decltype(gate(innovation)), MaskOf<T>> ||
      std::same_as<decltype(gate(innovation)), T>;
};

namespace detail {

/// What a type lacks to be a gate, in words.
template <class G, class T, int Dim>
consteval bool check_gate() {
  static_assert(UpdateGate<G, T, Dim>,
                "wayfare: a gate has a const member operator()(const Innovation<T, Dim>&), which "
                "returns whether the measurement is used, a bool, or its weight, a T");
  return true;
}

/// Whether the gate lets a measurement pass; sets its weight, if the gate returns one.
template <class G, class T, int Dim>
[[nodiscard]] MaskOf<T> passes(const G& gate, const Innovation<T, Dim>& innovation, T& weight) {
  if constexpr (std::same_as<decltype(gate(innovation)), MaskOf<T>>) {
    return gate(innovation);
  } else {
    weight = gate(innovation);
    return weight > T(0) && wayfare::is_finite(weight);
  }
}
template <class G, class T, int Dim>
inline constexpr bool kGivesWeight =
    std::same_as<decltype(std::declval<const G&>()(std::declval<const Innovation<T, Dim>&>())), T>;

/// |innovation| at most this many of its own σ.
template <class T>
struct SigmaLimit {
  T sigmas;
  [[nodiscard]] MaskOf<T> operator()(const Innovation<T, 1>& i) const {
    return i.value * i.value <= sigmas * sigmas * i.covariance;
  }
};

/// Normalised innovation squared of at most this.
template <class T>
struct NisLimit {
  T limit;
  template <int Dim>
  [[nodiscard]] bool operator()(const Innovation<T, Dim>& i) const {
    return i.nis <= limit;
  }
};

}  // namespace detail

}  // namespace wayfare
