#pragma once

#include <algorithm>
#include <limits>

#include <Eigen/Core>

namespace wayfare::testing {

/// The smallest pivot of the factorisation L D Lᵀ of `m` (symmetric, its lower triangle is read):
/// above 0 exactly where `m` is positive definite, never above its smallest diagonal element. From
/// the first pivot that is not positive on nothing further is looked at; NaN counts as that. By
/// hand, since a decomposition of Eigen's takes every test that uses it seconds to compile.
[[nodiscard]] inline double least_pivot(Eigen::MatrixXd m) {
  double least = std::numeric_limits<double>::infinity();
  for (Eigen::Index k = 0; k < m.rows(); ++k) {
    const double pivot = m(k, k);
    if (!(pivot > 0.0)) return pivot;
    least = std::min(least, pivot);
    for (Eigen::Index j = k + 1; j < m.rows(); ++j) {
      const double factor = m(j, k) / pivot;
      for (Eigen::Index i = j; i < m.rows(); ++i) m(i, j) -= m(i, k) * factor;
    }
  }
  return least;
}

}  // namespace wayfare::testing
