#include "slam/graph_slam/node_map.hpp"

#include <algorithm>
#include <utility>

namespace wayfare {

void NodeMap::start(const SE2d& pose, const PointSet& points) {
  graph_.add_pose(pose);
  views_.push_back({points, 0.0});
}

void NodeMap::append(const SE2d& pose, const PointSet& points, const Eigen::Matrix3d& information) {
  const int before = latest();
  const SE2d step = this->pose(before).inverse() * pose;
  views_.push_back({points, travel_m(before) + step.translation().norm()});
  graph_.edges.push_back({before, graph_.add_pose(pose), step, information, false});
}

std::vector<PlacedPoints> NodeMap::chain(int first, int last, double radius_m) const {
  std::vector<PlacedPoints> result;
  const int end = std::min(last, latest());
  for (int k = std::max(first, 0); k <= end; ++k)
    if (distance_m(k, end) < radius_m) result.push_back(placed(k));
  return result;
}

std::vector<PlacedPoints> NodeMap::around(const SE2d& place, double radius_m,
                                          std::size_t most) const {
  std::vector<std::pair<double, int>> near;
  for (int k = 0; k < size(); ++k) {
    const double d = (pose(k).translation() - place.translation()).norm();
    if (d < radius_m) near.emplace_back(d, k);
  }
  std::sort(near.begin(), near.end());
  near.resize(std::min(near.size(), most));
  std::vector<PlacedPoints> result;
  result.reserve(near.size());
  for (const auto& [d, k] : near) result.push_back(placed(k));
  return result;
}

}  // namespace wayfare
