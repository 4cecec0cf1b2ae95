#pragma once

#include <cmath>

#include <wayfare/sensors/point_set.hpp>

namespace wayfare {

struct WallPointsOptions {
  double spacing_m = 0.05;  ///< between the interpolated points
  double max_gap_m = 1.0;   ///< between neighbours on one wall
  double min_cos = 0.97;    ///< of the angle between a gap and the adjacent ones
};

/// A scan's end points, in the order of their beams, with points interpolated on straight walls
/// between neighbours. A wall seen at a shallow angle is otherwise a row of separate dots, the same
/// in the next scan wherever the robot moved along it, and matching would underestimate the motion.
[[nodiscard]] inline PointSet with_walls(const PointSet& ends, const WallPointsOptions& o) {
  PointSet points;
  points.reserve(2 * ends.size());
  const auto gap_after = [&](std::size_t i) { return Eigen::Vector2f(ends[i + 1] - ends[i]); };
  const auto straight = [&](const Eigen::Vector2f& a, const Eigen::Vector2f& b) {
    return static_cast<double>(a.dot(b)) >= o.min_cos * static_cast<double>(a.norm() * b.norm());
  };
  for (std::size_t i = 0; i < ends.size(); ++i) {
    points.push_back(ends[i]);
    if (i == 0 || i + 2 >= ends.size()) continue;
    const Eigen::Vector2f gap = gap_after(i);
    const auto length = static_cast<double>(gap.norm());
    if (length > o.max_gap_m || !straight(gap_after(i - 1), gap) ||
        !straight(gap, gap_after(i + 1)))
      continue;
    const int parts = static_cast<int>(std::ceil(length / o.spacing_m));
    for (int k = 1; k < parts; ++k)
      points.push_back(ends[i] + gap * (static_cast<float>(k) / static_cast<float>(parts)));
  }
  return points;
}

}  // namespace wayfare
