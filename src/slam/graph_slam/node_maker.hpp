#pragma once

#include <Eigen/Core>

#include <wayfare/slam/graph_slam.hpp>

#include "slam/graph_slam/local_map.hpp"
#include "slam/graph_slam/node_map.hpp"
#include "slam/motion.hpp"

namespace wayfare {

/// Adds a node after sufficient motion, with the information of its edge.
class NodeMaker {
 public:
  explicit NodeMaker(const GraphSlamOptions& options) : options_(options) {}

  /// Accumulates the covariance of the motion since the previous scan.
  void accumulate(const Motion& motion);

  /// Whether `pose` is far enough from the latest node for another.
  [[nodiscard]] bool is_due(const NodeMap& nodes, const SE2d& pose) const;

  /// Adds a node at `pose`, estimated by `match`.
  void add(NodeMap& nodes, const SE2d& pose, const PointSet& points, const Placement& match);

 private:
  [[nodiscard]] Eigen::Matrix3d information(const SE2d& step, const SO2d& rotation,
                                            const Placement& match) const;

  GraphSlamOptions options_;
  Eigen::Matrix3d since_node_ = Eigen::Matrix3d::Zero();  // covariance of the motion since the node
};

}  // namespace wayfare
