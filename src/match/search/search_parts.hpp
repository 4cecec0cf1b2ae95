#pragma once

// What branch and bound in wide and in small windows have in common.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "match/search/candidates.hpp"

namespace wayfare::detail {

/// A smaller sum cannot be better than the best: the log prior is never positive.
inline std::int64_t least_sum(const CandidateSpace& s, const Best& best) {
  if (best.objective <= 0) return 0;
  return static_cast<std::int64_t>(std::floor(best.objective / s.weight * (1 - 1e-12)));
}

/// Of the numbers from `first` on, `count` of them.
inline int nearest_to_zero(int first, int count) {
  return first > 0 ? first : std::min(0, first + count - 1);
}

/// Points looked at before any other.
inline constexpr int kFirst = 48;

/// The points in an order in which the first come from all over the scan, as those tell most.
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
