#pragma once

#include <vector>

#include <wayfare/graph/pose_graph.hpp>
#include <wayfare/slam/detail/graph_slam/node_map.hpp>
#include <wayfare/slam/detail/loops.hpp>
#include <wayfare/slam/graph_slam.hpp>

namespace wayfare::detail {

/// Merges nodes of known area into older ones, so that their number grows with the area and not
/// with time (after Johannsson et al. 2013, reduced pose graphs).
///
/// A node that leaves the window of the latest is merged if an older node of an earlier visit has
/// nearly its pose, and if edges join it to such nodes with a small uncertainty. Its edges are
/// replaced by compositions, so that what it measured between the nodes that remain is kept; their
/// number for each of those is limited. Its scans then follow the older node.
class NodeMerger {
 public:
  explicit NodeMerger(const GraphSlamOptions& options) : options_(options) {}

  /// Whether nodes are merged at this size of the graph.
  [[nodiscard]] bool is_on(const NodeMap& nodes) const {
    return options_.nodes_before_merging > 0 &&
           (nodes.merged() || nodes.size() > options_.nodes_before_merging);
  }
  /// To be called after each node; the number of nodes removed.
  int update(NodeMap& nodes, std::vector<ScanPose>& scans);

  /// Nodes that stay, the first ones; to be set with a restored graph.
  [[nodiscard]] int& kept() { return kept_; }

 private:
  /// An edge between a kept node and the node that leaves the window, seen from the kept one.
  struct Link {
    std::size_t edge = 0;
    int node = 0;  // kept
    SE2d T_node_leaving;
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  };

  [[nodiscard]] std::vector<Link> links(const NodeMap& nodes) const;
  [[nodiscard]] bool is_known(const NodeMap& nodes, const Link& link) const;
  [[nodiscard]] int nearest_older(const NodeMap& nodes) const;
  void merge(NodeMap& nodes, const std::vector<Link>& links, const Link& anchor, int older,
             std::vector<ScanPose>& scans);
  void join_kept(NodeMap& nodes, const std::vector<Link>& links, const Link& anchor);

  GraphSlamOptions options_;
  int kept_ = 0;
};

}  // namespace wayfare::detail
