#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include <Eigen/Core>

#include <wayfare/graph/pose_graph.hpp>

#include "slam/submap_slam/packed_points.hpp"

namespace wayfare {

/// A scan that was kept.
struct SubmapNode {
  int pose = 0;  ///< its place in the graph
  SE2d T_local_node;
  double travel_m = 0.0;  ///< from the first node
  std::shared_ptr<const PackedPoints> points;
};

/// Nodes first … last, in the frame of where the first was, with the local frame's axes.
struct Submap {
  std::int64_t id = 0;  ///< counted from the first ever
  int pose = 0;         ///< its place in the graph
  SE2d T_local_submap;
  int first = 0, last = 0;
  bool finished = false;
};

/// Submaps, nodes and what joins them. The local frame is that of the scans' way from one to the
/// next, which no loop closure bends.
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
  /// What loop closures have bent: T_map_local at the latest node.
  [[nodiscard]] SE2d T_map_local() const {
    return pose(latest()) * nodes.back().T_local_node.inverse();
  }

  /// A node, joined to the one before by what `information` says of the step between them.
  void add_node(const SE2d& T_local_node, std::shared_ptr<const PackedPoints> points,
                const Eigen::Matrix3d& information);
  /// Joins the latest node to a submap by where it was matched there.
  void join_latest(const Submap& submap, const Eigen::Matrix3d& information);
  /// A submap of which the latest node is the first.
  void begin_submap();
  /// Forgets the oldest submap with the nodes that are in no other; gives how many those were.
  int forget_oldest();

 private:
  void drop_poses(const std::vector<char>& gone);

  std::int64_t next_id_ = 0;
  friend struct SubmapState;
};

}  // namespace wayfare
