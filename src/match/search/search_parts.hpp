#pragma once

// Shared by the branch-and-bound searches of wide and of small windows.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "match/search/candidates.hpp"

namespace wayfare::detail {

/// Sums below cannot exceed the best objective, as the log prior is never positive.
inline std::int64_t min_useful_sum(const CandidateSpace& s, const Best& best) {
  if (best.objective <= 0) return 0;
  return static_cast<std::int64_t>(std::floor(best.objective / s.weight * (1 - 1e-12)));
}

/// Of the `count` integers from `first`.
inline int nearest_to_zero(int first, int count) {
  return first > 0 ? first : std::min(0, first + count - 1);
}

/// Number of points used first.
inline constexpr int kFirst = 48;

/// Orders the points so that the first kFirst are spread over the scan and most informative.
inline void interleave(const PointSet& points, std::vector<float>& x, std::vector<float>& y) {
  const std::size_t n = points.size(), stride = (n + kFirst - 1) / kFirst;
  x.assign(points.padded_x_m().size(), 0.0F);
  y.assign(points.padded_x_m().size(), 0.0F);
  std::size_t out = 0;
  for (std::size_t first = 0; first < stride; ++first)
    for (std::size_t i = first; i < n; i += stride, ++out) {
      x[out] = points.x_m()[i];
      y[out] = points.y_m()[i];
    }
}

}  // namespace wayfare::detail
