#pragma once

#include <algorithm>
#include <cstddef>
#include <limits>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include <wayfare/graph/pose_graph.hpp>
#include <wayfare/map/likelihood_field.hpp>
#include <wayfare/sensors/point_set.hpp>

namespace wayfare::detail {

/// What was seen from a node.
struct NodeView {
  PointSet points;
  double travel_m = 0.0;
};

/// The nodes: a pose graph, and for each pose the points seen from it. Indices start at 0; the
/// latest is last.
class NodeMap {
 public:
  [[nodiscard]] int size() const { return graph_.size(); }
  [[nodiscard]] int latest() const { return size() - 1; }
  [[nodiscard]] const SE2d& pose(int k) const { return graph_.poses[static_cast<std::size_t>(k)]; }
  [[nodiscard]] const PointSet& points(int k) const { return view(k).points; }  ///< base frame
  /// Path length from the first node, by the poses at the time the nodes were added.
  [[nodiscard]] double travel_m(int k) const { return view(k).travel_m; }
  [[nodiscard]] double distance_m(int a, int b) const {
    return (pose(a).translation() - pose(b).translation()).norm();
  }

  [[nodiscard]] const PoseGraph2& graph() const { return graph_; }
  [[nodiscard]] PoseGraph2& graph() { return graph_; }
  /// One for each pose.
  [[nodiscard]] std::vector<NodeView>& views() { return views_; }

  /// The first node.
  void start(const SE2d& pose, const PointSet& points) {
    graph_.add_pose(pose);
    views_.push_back({points, 0.0});
  }
  /// A node joined to the latest by the relative pose.
  void append(const SE2d& pose, const PointSet& points, const Eigen::Matrix3d& information) {
    const int before = latest();
    const SE2d step = this->pose(before).inverse() * pose;
    views_.push_back({points, travel_m(before) + step.translation().norm()});
    graph_.edges.push_back({before, graph_.add_pose(pose), step, information, false});
  }

  /// Removes node k, to which no edge may lead; the numbers of later ones decrease.
  void erase(int k) {
    graph_.poses.erase(graph_.poses.begin() + k);
    views_.erase(views_.begin() + k);
    for (PoseEdge<SE2d>& e : graph_.edges) {
      e.from -= e.from > k ? 1 : 0;
      e.to -= e.to > k ? 1 : 0;
    }
    merged_ = true;
  }
  /// Whether nodes were merged into others: consecutive ones need not have been passed in a row.
  [[nodiscard]] bool& merged() { return merged_; }
  [[nodiscard]] bool merged() const { return merged_; }

  /// Nodes first..last, as far as they exist, within `radius_m` of the last of them.
  [[nodiscard]] std::vector<PlacedPoints> chain(
      int first, int last, double radius_m = std::numeric_limits<double>::infinity()) const {
    std::vector<PlacedPoints> result;
    const int end = std::min(last, latest());
    for (int k = std::max(first, 0); k <= end; ++k)
      if (distance_m(k, end) < radius_m) result.push_back({&points(k), pose(k)});
    return result;
  }
  /// The `most` of the nodes before `end` nearest to a pose, within `radius_m`.
  [[nodiscard]] std::vector<PlacedPoints> around(const SE2d& place, double radius_m,
                                                 std::size_t most,
                                                 int end = std::numeric_limits<int>::max()) const {
    std::vector<std::pair<double, int>> near;
    for (int k = 0; k < std::min(end, size()); ++k) {
      const double d = (pose(k).translation() - place.translation()).norm();
      if (d < radius_m) near.emplace_back(d, k);
    }
    std::sort(near.begin(), near.end());
    near.resize(std::min(near.size(), most));
    std::vector<PlacedPoints> result;
    for (const auto& [d, k] : near) result.push_back({&points(k), pose(k)});
    return result;
  }

 private:
  [[nodiscard]] const NodeView& view(int k) const { return views_[static_cast<std::size_t>(k)]; }

  PoseGraph2 graph_;
  std::vector<NodeView> views_;  // one per pose
  bool merged_ = false;
};

}  // namespace wayfare::detail
