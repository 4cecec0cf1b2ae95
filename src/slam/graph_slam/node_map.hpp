#pragma once

#include <cstddef>
#include <limits>
#include <vector>

#include <Eigen/Core>

#include <wayfare/graph/pose_graph.hpp>
#include <wayfare/map/likelihood_field.hpp>
#include <wayfare/sensors/point_set.hpp>

namespace wayfare {

/// The nodes so far: a pose graph, and for each of its poses the points seen from there. Nodes are
/// counted from 0, the latest last.
class NodeMap {
 public:
  [[nodiscard]] int size() const { return graph_.size(); }
  [[nodiscard]] int latest() const { return size() - 1; }
  [[nodiscard]] const SE2d& pose(int k) const { return graph_.poses[static_cast<std::size_t>(k)]; }
  [[nodiscard]] const PointSet& points(int k) const { return view(k).points; }  ///< base frame
  /// Way from the first node, along the nodes as they were when they were made.
  [[nodiscard]] double travel_m(int k) const { return view(k).travel_m; }
  [[nodiscard]] double distance_m(int a, int b) const {
    return (pose(a).translation() - pose(b).translation()).norm();
  }

  [[nodiscard]] const PoseGraph2& graph() const { return graph_; }
  [[nodiscard]] PoseGraph2& graph() { return graph_; }

  /// The first node.
  void start(const SE2d& pose, const PointSet& points);
  /// A node joined to the latest by the step between them.
  void append(const SE2d& pose, const PointSet& points, const Eigen::Matrix3d& information);

  /// Nodes first..last, as far as there are such, that are within `radius_m` of the last of them.
  [[nodiscard]] std::vector<PlacedPoints> chain(
      int first, int last, double radius_m = std::numeric_limits<double>::infinity()) const;
  /// The `most` nodes nearest to a place, within `radius_m`.
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
  std::vector<View> views_;  // one a pose
};

}  // namespace wayfare
