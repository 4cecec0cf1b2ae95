#pragma once

#include <algorithm>
#include <limits>

#include <Eigen/Core>

namespace wayfare::testing {

/// The smallest pivot of the factorisation L D Lᵀ of `m` (symmetric, its lower triangle is read):
/// above 0 exactly if `m` is positive definite, never above its smallest diagonal element. Stops at
/// the first pivot that is not positive or is NaN. Not an Eigen decomposition, which adds seconds
/// to the compilation of every test.
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
