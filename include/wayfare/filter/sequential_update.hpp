#pragma once

// Measurements taken one number after the other (sequential processing: Maybeck 1979, 7.4; Simon
// 2006, 6.1), on a covariance in any storage: the covariance is updated after each, the estimate
// once after the last.

#include <algorithm>
#include <array>
#include <cstddef>
#include <type_traits>
#include <utility>

#include <Eigen/Core>

namespace wayfare {

/// A row of a measurement's Jacobian with `value[k]` at the k-th of `Index`, else zero.
template <class T, int... Index>
struct IndexedRow {
  std::array<T, sizeof...(Index)> value;  ///< at each Index

  /// Σ value·x(index).
  template <class X>
  [[nodiscard]] T sum(X x) const {
    const std::array<T, sizeof...(Index)> terms{T(x(Index))...};
    T result = value[0] * terms[0];
    for (std::size_t k = 1; k < terms.size(); ++k) result += value[k] * terms[k];
    return result;
  }
};

/// A symmetric N×N matrix that stores each element once and so remains symmetric. Initially zero.
template <class T, int N>
class SymmetricMatrix {
 public:
  using Vector = std::array<T, N>;  ///< a column

  /// Element (i, j), which is element (j, i).
  T& operator()(int i, int j) { return upper_[at(i, j)]; }
  /// Element (i, j), which is element (j, i).
  const T& operator()(int i, int j) const { return upper_[at(i, j)]; }

  /// The first K elements of column j ≥ K − 1, which are adjacent in memory.
  template <int K>
  [[nodiscard]] auto head(int j) {
    return Eigen::Map<Eigen::Matrix<T, K, 1>>(&upper_[at(0, j)]);
  }

  /// *this −= v·vᵀ·scale.
  void subtract_outer(const Vector& v, T scale) { subtract_columns(v, scale, kIndices); }

  /// *this · h.
  template <int... Index>
  [[nodiscard]] Vector times(const IndexedRow<T, Index...>& h) const {
    Vector result;
    for (int i = 0; i < N; ++i)
      result[static_cast<std::size_t>(i)] = h.sum([&](int j) { return (*this)(i, j); });
    return result;
  }

  /// Of a state of which element I becomes itself plus h·x, where `h` is zero at I.
  template <int I, int... Index>
  void add_to(const IndexedRow<T, Index...>& h) {
    const Vector cross = times(h);
    const auto element = [&](int j) { return cross[static_cast<std::size_t>(j)]; };
    for (int j = 0; j < I; ++j) (*this)(j, I) += element(j);
    for (int j = I + 1; j < N; ++j) (*this)(I, j) += element(j);
    (*this)(I, I) += T(2) * cross[I] + h.sum(element);
  }

  /// Element i becomes uncorrelated with all others, with `variance`.
  void decouple(int i, T variance) {
    for (int j = 0; j < N; ++j) (*this)(i, j) = T(0);
    (*this)(i, i) = variance;
  }

  /// All elements, both triangles.
  [[nodiscard]] Eigen::Matrix<T, N, N> dense() const {
    Eigen::Matrix<T, N, N> m;
    for (int j = 0; j < N; ++j)
      for (int i = 0; i < N; ++i) m(i, j) = (*this)(i, j);
    return m;
  }

 private:
  static constexpr auto kIndices = std::make_integer_sequence<int, N>{};
  /// Each column as one vector of fixed size, on which Eigen works by whole registers.
  template <int... J>
  void subtract_columns(const Vector& v, T scale, std::integer_sequence<int, J...>) {
    ((head<J + 1>(J) -= Eigen::Map<const Eigen::Matrix<T, J + 1, 1>>(v.data()) * (v[J] * scale)),
     ...);
  }
  static constexpr std::size_t at(int i, int j) {
    return static_cast<std::size_t>(i <= j ? j * (j + 1) / 2 + i : i * (i + 1) / 2 + j);
  }

  std::array<T, static_cast<std::size_t>(N*(N + 1) / 2)> upper_{};
};

/// A row of H of which only K entries are not zero.
template <class T, int K>
struct SparseRow {
  std::array<int, K> index;  ///< columns of H
  std::array<T, K> value;    ///< their values
};

/// A scalar measurement, linearised at the predicted state: innovation z − h(x), row of ∂h/∂x in
/// the state's tangent (a 1×n matrix or a SparseRow), variance of the noise.
template <class T, class Row>
struct ScalarMeasurement {
  T innovation;  ///< z − h(x)
  Row row;       ///< ∂h/∂x
  T variance;    ///< R
};

/// A covariance P, in whatever storage: `times(h)` is P hᵀ, `subtract_outer(v, s)` is P −= v vᵀ s.
/// Vectors are indexed by [] and know their size(). SymmetricMatrix is one.
template <class P, class Row>
concept SequentialCovariance = requires(P& p, const P& c, const Row& h) {
  c.times(h);
  p.subtract_outer(c.times(h), c.times(h)[0]);
};

/// A dense covariance as sequential updates need it. Rounding leaves it not quite symmetric.
template <class Matrix>
struct DenseCovariance {
  using T = typename Matrix::Scalar;                              ///< of the elements
  using Vector = Eigen::Matrix<T, Matrix::RowsAtCompileTime, 1>;  ///< a column
  Matrix& p;  ///< the covariance, updated in place

  /// P hᵀ.
  template <int... Index>
  [[nodiscard]] Vector times(const IndexedRow<T, Index...>& h) const {
    Vector result = Vector::Zero(p.rows());
    std::size_t k = 0;
    ((result += h.value[k++] * p.col(Index)), ...);
    return result;
  }
  /// P −= v vᵀ·scale.
  void subtract_outer(const Vector& v, T scale) { p.noalias() -= v * (scale * v).transpose(); }
};

namespace detail {

/// v[i] with the index type of std::array or of Eigen.
template <class V>
[[nodiscard]] auto& element(V& v, int i) {
  return v[static_cast<decltype(v.size())>(i)];
}

}  // namespace detail

/// What is expected of an innovation before it is known.
template <class T, class Vector>
struct ExpectedInnovation {
  Vector cross;  ///< its covariance with the state: P hᵀ
  T variance;    ///< from the state alone: h P hᵀ
};

// `inline` raises the compiler's size limit for inlining, on which the speed of the filters
// depends.
/// What `p` expects of the innovation of a measurement with the row `h`.
template <class T, int... Index, SequentialCovariance<IndexedRow<T, Index...>> P>
[[nodiscard]] inline auto expected_innovation(const P& p, const IndexedRow<T, Index...>& h) {
  auto cross = p.times(h);
  const T variance = h.sum([&](int i) { return detail::element(cross, i); });
  return ExpectedInnovation<T, decltype(cross)>{std::move(cross), variance};
}

/// The correction of one element: its covariance with the innovation, times what is left of the
/// innovation, times the inverse of the innovation's variance.
struct WeightedInnovation {
  /// cross · left · weight.
  template <class T>
  T operator()(T cross, T left, T weight) const {
    return cross * (left * weight);
  }
};

/// One scalar measurement with Jacobian `h`, variance `r` and innovation measured minus predicted,
/// at the estimate without `correction`: the sum of the corrections since the estimate was last
/// moved, to which its own is added. `gain` multiplies the three factors of that in an order of its
/// own, for results that must stay the same to the last bit. Returns the square of the innovation,
/// less what the correction explains, over its variance: χ² with one degree of freedom.
template <class T, int... Index, SequentialCovariance<IndexedRow<T, Index...>> P, class Vector,
          class Correction, class Gain = WeightedInnovation>
inline T sequential_update(P& p, Correction& correction, const IndexedRow<T, Index...>& h,
                           const ExpectedInnovation<T, Vector>& expected,
                           std::type_identity_t<T> innovation, std::type_identity_t<T> r,
                           Gain gain = {}) {
  // Rounding must not make the variance negative: a gain of the wrong sign would follow. A number
  // known exactly that is measured exactly stays as it is.
  const T variance = std::max(expected.variance, T(0)) + r;
  const T weight = variance > T(0) ? T(1) / variance : T(0);
  const T left = innovation - h.sum([&](int i) { return detail::element(correction, i); });
  for (int i = 0; i < static_cast<int>(expected.cross.size()); ++i)
    detail::element(correction, i) += gain(detail::element(expected.cross, i), left, weight);
  p.subtract_outer(expected.cross, weight);
  return left * left * weight;
}

/// The same, with what is expected computed here.
template <class T, int... Index, SequentialCovariance<IndexedRow<T, Index...>> P, class Correction>
inline T sequential_update(P& p, Correction& correction, const IndexedRow<T, Index...>& h,
                           std::type_identity_t<T> innovation, std::type_identity_t<T> r) {
  return sequential_update(p, correction, h, expected_innovation(p, h), innovation, r);
}

}  // namespace wayfare
