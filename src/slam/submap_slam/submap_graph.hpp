#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include <Eigen/Core>

#include <wayfare/graph/pose_graph.hpp>

#include "slam/submap_slam/packed_points.hpp"

namespace wayfare {

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
                const Eigen::Matrix3d& information);
  /// Joins the latest node to a submap by its pose in it.
  void join_latest(const Submap& submap, const Eigen::Matrix3d& information);
  /// A submap whose first node is the latest one.
  void begin_submap();
  /// Drops the oldest submap with the nodes in no other; returns the number of those nodes.
  int forget_oldest();

 private:
  void drop_poses(const std::vector<char>& gone);

  std::int64_t next_id_ = 0;
  friend struct SubmapState;
};

}  // namespace wayfare
