#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include <wayfare/graph/pose_graph.hpp>
#include <wayfare/sensors/point_set.hpp>

namespace wayfare {

/// Points in a quarter of a PointSet's memory, at a resolution of 2 mm.
class PackedPoints {
 public:
  static constexpr float kUnit_m = 0.002F;  // ±65 m
  static constexpr double kMaxRange_m = 60.0;

  PackedPoints() = default;
  /// All points lie within kMaxRange_m along each axis.
  explicit PackedPoints(const PointSet& points) {
    xy_.reserve(2 * points.size());
    for (std::size_t i = 0; i < points.size(); ++i)
      for (const float t : {points[i].x(), points[i].y()})
        xy_.push_back(static_cast<std::int16_t>(std::lround(t / kUnit_m)));
  }
  explicit PackedPoints(std::vector<std::int16_t> xy) : xy_(std::move(xy)) {}

  [[nodiscard]] PointSet unpacked() const {
    PointSet points;
    points.reserve(xy_.size() / 2);
    for (std::size_t i = 0; i + 1 < xy_.size(); i += 2)
      points.push_back(
          {kUnit_m * static_cast<float>(xy_[i]), kUnit_m * static_cast<float>(xy_[i + 1])});
    return points;
  }

  [[nodiscard]] const std::vector<std::int16_t>& xy() const { return xy_; }

 private:
  std::vector<std::int16_t> xy_;
};

/// A scan in the graph.
struct SubmapNode {
  int pose = 0;  ///< index in the graph
  SE2d T_local_node;
  double travel_m = 0.0;  ///< from the first node
  std::shared_ptr<const PackedPoints> points;
};

/// Nodes first … last, in a frame at the first node's position with the local frame's axes.
struct Submap {
  std::int64_t id = 0;  ///< counted from the first ever
  int pose = 0;         ///< index in the graph
  SE2d T_local_submap;
  int first = 0, last = 0;
  bool finished = false;
};

/// Submaps, nodes and the edges between them. The local frame is that of scan-to-scan tracking,
/// which loop closures do not deform.
class SubmapGraph {
 public:
  std::vector<SubmapNode> nodes;
  std::vector<Submap> submaps;  ///< the unfinished ones last: one, or two that overlap
  PoseGraph2 graph;

  [[nodiscard]] int latest() const { return static_cast<int>(nodes.size()) - 1; }
  [[nodiscard]] const SubmapNode& node(int k) const { return nodes[static_cast<std::size_t>(k)]; }
  [[nodiscard]] const SE2d& pose(int k) const { return graph_pose(node(k).pose); }
  [[nodiscard]] const SE2d& graph_pose(int index) const {
    return graph.poses[static_cast<std::size_t>(index)];
  }
  /// T_map_local at the latest node: the correction by loop closures.
  [[nodiscard]] SE2d T_map_local() const {
    return pose(latest()) * nodes.back().T_local_node.inverse();
  }

  /// Adds a node, joined to the previous one by their relative pose with `information`.
  void add_node(const SE2d& T_local_node, std::shared_ptr<const PackedPoints> points,
                const Eigen::Matrix3d& information) {
    const SubmapNode& before = nodes.back();
    const SE2d step = before.T_local_node.inverse() * T_local_node;
    const double travel_m = before.travel_m + step.translation().norm();
    graph.edges.push_back({before.pose, graph.size(), step, information, false});
    const int at = graph.add_pose(pose(latest()) * step);
    nodes.push_back({at, T_local_node, travel_m, std::move(points)});
  }
  /// Adds a node that is joined to none, at this pose of the map.
  void add_first_node(const SE2d& T_map_node, const SE2d& T_local_node,
                      std::shared_ptr<const PackedPoints> points) {
    const double travel_m = nodes.empty() ? 0.0 : nodes.back().travel_m;
    const int at = graph.add_pose(T_map_node);
    nodes.push_back({at, T_local_node, travel_m, std::move(points)});
  }
  /// Joins the latest node to a submap by its pose in it.
  void join_latest(const Submap& submap, const Eigen::Matrix3d& information) {
    const SubmapNode& n = nodes.back();
    graph.edges.push_back({submap.pose, n.pose, submap.T_local_submap.inverse() * n.T_local_node,
                           information, false});
  }
  /// A submap whose first node is the latest one.
  void begin_submap() {
    const SubmapNode& n = nodes.back();
    const SE2d T_local_submap(n.T_local_node.translation(), SO2d());
    const int at = graph.add_pose(T_map_local() * T_local_submap);
    submaps.push_back({next_id_++, at, T_local_submap, latest(), latest(), false});
    constexpr double kExact = 1e6;  // to the millimetre
    join_latest(submaps.back(), kExact * Eigen::Matrix3d::Identity());
  }

  /// Drops the oldest submap with the nodes in no other; returns the number of those nodes.
  int forget_oldest() {
    const int kept = submaps[1].first;
    std::vector<char> gone(graph.poses.size(), 0);
    gone[static_cast<std::size_t>(submaps[0].pose)] = 1;
    for (int k = 0; k < kept; ++k) gone[static_cast<std::size_t>(node(k).pose)] = 1;
    submaps.erase(submaps.begin());
    nodes.erase(nodes.begin(), nodes.begin() + kept);
    for (Submap& s : submaps) {
      s.first -= kept;
      s.last -= kept;
    }
    drop_poses(gone);
    return kept;
  }

 private:
  void drop_poses(const std::vector<char>& gone) {
    std::vector<int> place(gone.size(), -1);
    PoseGraph2 rest;
    for (std::size_t i = 0; i < gone.size(); ++i)
      if (gone[i] == 0) place[i] = rest.add_pose(graph.poses[i]);
    const auto at = [&](int pose) { return place[static_cast<std::size_t>(pose)]; };
    for (PoseEdge<SE2d> e : graph.edges) {
      e.from = at(e.from);
      e.to = at(e.to);
      if (e.from >= 0 && e.to >= 0) rest.edges.push_back(e);
    }
    for (SubmapNode& n : nodes) n.pose = at(n.pose);
    for (Submap& s : submaps) s.pose = at(s.pose);
    graph = std::move(rest);
  }

  std::int64_t next_id_ = 0;
  friend struct SubmapState;
};

}  // namespace wayfare
