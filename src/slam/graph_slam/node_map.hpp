#pragma once

#include <cstddef>
#include <limits>
#include <vector>

#include <Eigen/Core>

#include <wayfare/graph/pose_graph.hpp>
#include <wayfare/map/likelihood_field.hpp>
#include <wayfare/sensors/point_set.hpp>

namespace wayfare {

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

  /// The first node.
  void start(const SE2d& pose, const PointSet& points);
  /// A node joined to the latest by the relative pose.
  void append(const SE2d& pose, const PointSet& points, const Eigen::Matrix3d& information);

  /// Nodes first..last, as far as they exist, within `radius_m` of the last of them.
  [[nodiscard]] std::vector<PlacedPoints> chain(
      int first, int last, double radius_m = std::numeric_limits<double>::infinity()) const;
  /// The `most` nodes nearest to a pose, within `radius_m`.
  [[nodiscard]] std::vector<PlacedPoints> around(const SE2d& place, double radius_m,
                                                 std::size_t most) const;

 private:
  struct View {
    PointSet points;
    double travel_m = 0.0;
  };

  [[nodiscard]] const View& view(int k) const { return views_[static_cast<std::size_t>(k)]; }
  [[nodiscard]] PlacedPoints placed(int k) const { return {&points(k), pose(k)}; }

  PoseGraph2 graph_;
  std::vector<View> views_;  // one per pose
};

}  // namespace wayfare
