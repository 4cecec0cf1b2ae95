#include "slam/radar_slam/wall_points.hpp"

#include <cmath>

namespace wayfare {

PointSet with_walls(const PointSet& ends, const WallPointsOptions& o) {
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
