#pragma once

#include <array>
#include <cmath>
#include <cstddef>

#include <Eigen/Core>

namespace wayfare {

/// A row of a measurement's Jacobian with `value[k]` at the k-th of `Index`, else zero.
template <class T, int... Index>
struct IndexedRow {
  std::array<T, sizeof...(Index)> value;

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
  using Vector = std::array<T, N>;

  T& operator()(int i, int j) { return upper_[at(i, j)]; }
  const T& operator()(int i, int j) const { return upper_[at(i, j)]; }

  /// *this −= v·vᵀ·scale.
  void subtract_outer(const Vector& v, T scale) {
    for (int j = 0; j < N; ++j) {
      const T scaled = v[static_cast<std::size_t>(j)] * scale;
      for (int i = 0; i <= j; ++i) upper_[at(i, j)] -= v[static_cast<std::size_t>(i)] * scaled;
    }
  }

  /// *this · h.
  template <int... Index>
  [[nodiscard]] Vector times(const IndexedRow<T, Index...>& h) const {
    Vector result;
    for (int i = 0; i < N; ++i)
      result[static_cast<std::size_t>(i)] = h.sum([&](int j) { return (*this)(i, j); });
    return result;
  }

  /// Element i becomes uncorrelated with all others, with `variance`.
  void decouple(int i, T variance) {
    for (int j = 0; j < N; ++j) (*this)(i, j) = T(0);
    (*this)(i, i) = variance;
  }

  [[nodiscard]] bool all_finite() const {
    bool finite = true;
    for (const T& x : upper_) finite = finite && std::isfinite(x);
    return finite;
  }

  [[nodiscard]] Eigen::Matrix<T, N, N> dense() const {
    Eigen::Matrix<T, N, N> m;
    for (int j = 0; j < N; ++j)
      for (int i = 0; i < N; ++i) m(i, j) = (*this)(i, j);
    return m;
  }

 private:
  static constexpr std::size_t at(int i, int j) {
    return static_cast<std::size_t>(i <= j ? j * (j + 1) / 2 + i : i * (i + 1) / 2 + j);
  }

  std::array<T, static_cast<std::size_t>(N*(N + 1) / 2)> upper_{};
};

}  // namespace wayfare
