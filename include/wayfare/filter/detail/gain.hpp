#pragma once

// The gain of a vector measurement in plain loops: the decompositions and products of a matrix
// library take most of the time that an update takes to compile.

#include <cmath>
#include <optional>

#include <Eigen/Core>

namespace wayfare::detail {

/// a −= b cᵀ.
template <class T, int N, int M, int K>
void subtract_product(Eigen::Matrix<T, N, M>& a, const Eigen::Matrix<T, N, K>& b,
                      const Eigen::Matrix<T, M, K>& c) {
  for (int k = 0; k < K; ++k)
    for (int j = 0; j < M; ++j)
      for (int i = 0; i < N; ++i) a(i, j) -= b(i, k) * c(j, k);
}

/// s = L Lᵀ with the lower triangle L; nothing if s is not finite or not positive definite.
template <class T, int N>
[[nodiscard]] std::optional<Eigen::Matrix<T, N, N>> cholesky_factor(
    const Eigen::Matrix<T, N, N>& s) {
  for (int i = 0; i < N * N; ++i)
    if (!std::isfinite(s.data()[i])) return std::nullopt;
  Eigen::Matrix<T, N, N> l = s;
  for (int j = 0; j < N; ++j) {
    for (int k = 0; k < j; ++k)
      for (int i = j; i < N; ++i) l(i, j) -= l(i, k) * l(j, k);
    if (!(l(j, j) > T(0))) return std::nullopt;
    l(j, j) = std::sqrt(l(j, j));
    for (int i = j + 1; i < N; ++i) l(i, j) /= l(j, j);
  }
  return l;
}

/// K = G S⁻¹ in place of G = P Hᵀ, for the covariance S of an innovation. Returns its normalised
/// square; nothing if it is not finite, or S is not finite or not positive definite.
template <class T, int N, int Rows>
[[nodiscard]] std::optional<T> solve_gain(const Eigen::Matrix<T, Rows, Rows>& s,
                                          const Eigen::Matrix<T, Rows, 1>& innovation,
                                          Eigen::Matrix<T, N, Rows>& g) {
  const auto l = cholesky_factor(s);
  if (!l) return std::nullopt;
  Eigen::Matrix<T, Rows, 1> white = innovation;
  T nis(0);
  for (int c = 0; c < Rows; ++c) {
    if (!std::isfinite(innovation[c])) return std::nullopt;
    for (int k = 0; k < c; ++k) white[c] -= (*l)(c, k) * white[k];
    white[c] /= (*l)(c, c);
    nis += white[c] * white[c];
  }
  const auto column = [&](int c, int of, const T& factor) {
    for (int i = 0; i < N; ++i) g(i, c) -= factor * g(i, of);
  };
  const auto divide = [&](int c) {
    for (int i = 0; i < N; ++i) g(i, c) /= (*l)(c, c);
  };
  for (int c = 0; c < Rows; ++c) {
    for (int k = 0; k < c; ++k) column(c, k, (*l)(c, k));
    divide(c);
  }
  for (int c = Rows - 1; c >= 0; --c) {
    for (int k = c + 1; k < Rows; ++k) column(c, k, (*l)(k, c));
    divide(c);
  }
  return nis;
}

}  // namespace wayfare::detail
