#pragma once

// What a measurement of a filter is: a linearised one, or its error as a function of the state.
//
//   struct BeaconPosition {                              // seen from the robot, m
//     using Blocks = BlockList<Pose>;
//     using Jacobians = AutomaticJacobians;
//     static constexpr int kDim = 2;
//     Eigen::Vector2d measured_m, beacon_m;
//     Eigen::Matrix2d covariance;
//     template <class T>
//     Eigen::Matrix<T, 2, 1> error(const SE2<T>& pose) const {
//       return pose.inverse() * beacon_m.cast<T>() - measured_m.cast<T>();
//     }
//   };

#include <array>
#include <concepts>
#include <cstddef>
#include <tuple>
#include <type_traits>
#include <utility>

#include <Eigen/Core>

#include <wayfare/core/jacobian.hpp>
#include <wayfare/core/manifold.hpp>
#include <wayfare/core/pack.hpp>
#include <wayfare/filter/sequential_update.hpp>
#include <wayfare/filter/state.hpp>

namespace wayfare {

/// Rows of H of which only K columns are not zero: column `index[k]` is `value.col(k)`.
template <class T, int Rows, int K>
struct SparseRows {
  std::array<int, K> index;         ///< columns of H
  Eigen::Matrix<T, Rows, K> value;  ///< their values
};

/// A vector measurement, linearised at the predicted state: innovation z − h(x), H = ∂h/∂x in the
/// state's tangent (a matrix or SparseRows), covariance R of the noise, positive semi-definite.
template <class T, int Dim, class H>
struct VectorMeasurement {
  Eigen::Matrix<T, Dim, 1> innovation;    ///< z − h(x)
  H rows;                                 ///< ∂h/∂x
  Eigen::Matrix<T, Dim, Dim> covariance;  ///< R
};

namespace detail {

/// The blocks that a measurement takes; none named: the whole state.
template <class H>
struct MeasuredBlocks {
  using List = void;
};
template <class H>
requires requires { typename H::Blocks; }
struct MeasuredBlocks<H> {
  using List = typename H::Blocks;
};

/// Calls f with the values that a measurement takes.
template <class S, class... B, class F>
decltype(auto) with_blocks(const S& x, BlockList<B...>, const F& f) {
  return f(x.template get<B>()...);
}
template <class H, class M, class F>
decltype(auto) with_values(const M& x, const F& f) {
  if constexpr (std::same_as<typename MeasuredBlocks<H>::List, void>)
    return f(x);
  else
    return with_blocks(x, typename MeasuredBlocks<H>::List{}, f);
}

/// The places of the errors of what a measurement takes, in the state's tangent.
template <class S, class... B>
constexpr auto error_indices(std::type_identity<BlockList<B...>>) {
  return S::template indices<B...>();
}
template <class M>
constexpr auto error_indices(std::type_identity<void>) {
  std::array<int, static_cast<std::size_t>(ManifoldTraits<M>::kDof)> index{};
  for (std::size_t k = 0; k < index.size(); ++k) index[k] = static_cast<int>(k);
  return index;
}

template <class H>
using ErrorOf = Eigen::Matrix<double, H::kDim, 1>;

template <class H, class M, class Blocks>
inline constexpr bool kHasErrorOf = false;
template <class H, class M, class... B>
inline constexpr bool kHasErrorOf<H, M, BlockList<B...>> = requires(const H& h, const M& x) {
  { h.error(x.template get<B>()...) } -> std::convertible_to<ErrorOf<H>>;
};
template <class H, class M>
inline constexpr bool kHasErrorOf<H, M, void> = requires(const H& h, const M& x) {
  { h.error(x) } -> std::convertible_to<ErrorOf<H>>;
};
template <class H>
inline constexpr bool kHasCovariance = requires(const H& h) {
  { h.covariance } -> std::convertible_to<Eigen::Matrix<double, H::kDim, H::kDim>>;
};

}  // namespace detail

/// A linearised measurement: a const callable from a state to a ScalarMeasurement or a
/// VectorMeasurement.
template <class H, class M>
concept LinearisedMeasurement = requires(const H& h, const M& x) {
  h(x).innovation;
  requires requires {
    h(x).row;
    h(x).variance;
  } || requires {
    h(x).rows;
    h(x).covariance;
  };
};

/// A measurement by its error, as an edge of a factor graph has one: `kDim` and `error(x...)`,
/// predicted minus measured, of the state, or of the values of its `Blocks` (a BlockList).
/// Optional:
/// - `covariance` R of the error; without it the error is in standard deviations;
/// - `linearise(x..., JacobianBlocks<Eigen::Matrix<double, kDim, 1>, X...>&)`, which returns the
///   error and sets its Jacobians; else
/// - `using Jacobians = AutomaticJacobians`, where `error` is a template of the scalar; else they
///   are numeric.
template <class H, class M>
concept MeasurementError = std::same_as < typename ManifoldTraits<M>::Scalar,
double > &&detail::kHasErrorOf<H, M, typename detail::MeasuredBlocks<H>::List>;

template <class H, class M>
concept MeasurementModel = LinearisedMeasurement<H, M> || MeasurementError<H, M>;

namespace detail {

/// What a type lacks to be a measurement, in words.
template <class H, class M>
consteval bool check_measurement() {
  static_assert(
      requires {
        { H::kDim } -> std::convertible_to<int>;
      },
      "wayfare: a measurement has the size of its error, static constexpr int kDim, or is "
      "a callable that returns a ScalarMeasurement or a VectorMeasurement");
  if constexpr (requires { H::kDim; })
    static_assert(MeasurementError<H, M>,
                  "wayfare: a measurement has a const member error(x...), which takes the state or "
                  "the values of its Blocks and returns Eigen::Matrix<double, kDim, 1>");
  return true;
}

}  // namespace detail

/// The error of a measurement and its Jacobians by each value, by the means the measurement chose.
template <class H, class... V>
detail::ErrorOf<H> linearise_measurement(const H& h, JacobianBlocks<detail::ErrorOf<H>, V...>& by,
                                         const V&... x) {
  if constexpr (requires { h.linearise(x..., by); }) {
    return h.linearise(x..., by);
  } else {
    const auto error = [&h](const auto&... each) { return h.error(each...); };
    return differentiate<H, detail::ErrorOf<H>>(error, by, x...);
  }
}

/// The linearised measurement of a model at a state.
template <class M, MeasurementModel<M> H>
[[nodiscard]] auto measure(const H& h, const M& x) {
  if constexpr (LinearisedMeasurement<H, M>) {
    return h(x);
  } else {
    return detail::with_values<H>(x, [&]<class... V>(const V&... value) {
      constexpr int kDim = H::kDim, kColumns = (ManifoldTraits<V>::kDof + ...);
      JacobianBlocks<detail::ErrorOf<H>, V...> by;
      const Eigen::Matrix<double, kDim, 1> error = linearise_measurement(h, by, value...);
      using List = typename detail::MeasuredBlocks<H>::List;
      SparseRows<double, kDim, kColumns> rows;
      rows.index = detail::error_indices<M>(std::type_identity<List>{});
      rows.value = detail::side_by_side(by);
      Eigen::Matrix<double, kDim, kDim> covariance;
      if constexpr (detail::kHasCovariance<H>)
        covariance = h.covariance;
      else
        covariance.setIdentity();
      if constexpr (kDim == 1) {
        SparseRow<double, kColumns> row{rows.index, {}};
        for (std::size_t k = 0; k < kColumns; ++k)
          row.value[k] = rows.value(0, static_cast<Eigen::Index>(k));
        return ScalarMeasurement<double, decltype(row)>{-error[0], row, covariance(0, 0)};
      } else {
        return VectorMeasurement<double, kDim, decltype(rows)>{-error, rows, covariance};
      }
    });
  }
}

template <class H, class M>
concept ScalarMeasurementModel = MeasurementModel<H, M> && requires(const H& h, const M& x) {
  measure(h, x).row;
};
template <class H, class M>
concept VectorMeasurementModel = MeasurementModel<H, M> && requires(const H& h, const M& x) {
  measure(h, x).rows;
};

/// The result of an update, lane by lane for packs.
template <class T>
struct ScalarUpdate {
  T innovation;        ///< before the update
  T variance;          ///< of the innovation: h P hᵀ + R
  MaskOf<T> accepted;  ///< false: rejected by the gate or not finite, state unchanged

  /// Normalised innovation squared; χ² with one degree of freedom for a consistent filter.
  [[nodiscard]] T nis() const { return innovation * innovation / variance; }
};

/// The same of a vector measurement.
template <class T, int Rows>
struct VectorUpdate {
  Eigen::Matrix<T, Rows, 1> innovation;     ///< before the update
  Eigen::Matrix<T, Rows, Rows> covariance;  ///< of the innovation: H P Hᵀ + R
  T nis;          ///< normalised innovation squared; χ² with `Rows` degrees of freedom
  bool accepted;  ///< false: rejected by the limit, or not finite, state unchanged
};

}  // namespace wayfare
