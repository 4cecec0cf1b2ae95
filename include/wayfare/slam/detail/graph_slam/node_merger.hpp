#pragma once

#include <cstddef>
#include <vector>

#include <wayfare/graph/path_uncertainty.hpp>
#include <wayfare/graph/pose_graph.hpp>
#include <wayfare/slam/detail/graph_slam/node_map.hpp>
#include <wayfare/slam/detail/loops.hpp>
#include <wayfare/slam/graph_slam.hpp>

namespace wayfare::detail {

/// Whether nodes of known area are merged at this size of the graph.
[[nodiscard]] inline bool merges_nodes(const GraphSlamOptions& options, const NodeMap& nodes) {
  return options.nodes_before_merging > 0 &&
         (nodes.merged() || nodes.size() > options.nodes_before_merging);
}

/// Merges nodes of known area into older ones, so that their number grows with the area and not
/// with time (after Johannsson et al. 2013, reduced pose graphs).
///
/// A node that leaves the window of the latest is merged if an older node of an earlier visit has
/// nearly its pose, and if a path of edges leads to that with a small uncertainty. Its edges are
/// replaced by compositions with the least uncertain of them, so that what it measured between the
/// nodes that remain is kept; their number for each of those is limited. Its scans then follow the
/// older node.
class NodeMerger {
 public:
  explicit NodeMerger(const GraphSlamOptions& options) : options_(options) {}

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

  /// Those of the node that leaves the window.
  struct Edges {
    std::vector<Link> links;         // to kept nodes
    std::vector<std::size_t> later;  // to others
  };

  [[nodiscard]] Edges edges(const NodeMap& nodes) const;
  [[nodiscard]] bool is_known(const NodeMap& nodes, int older);
  [[nodiscard]] int nearest_older(const NodeMap& nodes) const;
  [[nodiscard]] const Link* anchor(const NodeMap& nodes, const std::vector<Link>& links) const;
  void merge(NodeMap& nodes, const Edges& own, const Link& anchor, int older,
             std::vector<ScanPose>& scans);
  void join_kept(NodeMap& nodes, const std::vector<Link>& links, const Link& anchor);

  PathUncertaintyFinder uncertainty_;
  std::vector<int> degree_;  // of each node
  GraphSlamOptions options_;
  int kept_ = 0;
};

}  // namespace wayfare::detail
