#pragma once

#include <Eigen/Core>

#include <wayfare/slam/graph_slam.hpp>

#include "slam/graph_slam/local_map.hpp"
#include "slam/graph_slam/node_map.hpp"
#include "slam/motion.hpp"

namespace wayfare {

/// Makes a node of a scan when the robot has moved enough, and says how sure the way there is.
class NodeMaker {
 public:
  explicit NodeMaker(const GraphSlamOptions& options) : options_(options) {}

  /// The robot made this motion since the scan before.
  void tell(const Motion& motion);

  /// Whether the robot at `pose` is far enough from the latest node for another.
  [[nodiscard]] bool is_due(const NodeMap& nodes, const SE2d& pose) const;

  /// Adds a node at `pose`, which `match` led to.
  void add(NodeMap& nodes, const SE2d& pose, const PointSet& points, const Placement& match);

 private:
  [[nodiscard]] Eigen::Matrix3d information(const SE2d& step, const SO2d& rotation,
                                            const Placement& match) const;

  GraphSlamOptions options_;
  Eigen::Matrix3d since_node_ = Eigen::Matrix3d::Zero();  // the motions' covariance since then
};

}  // namespace wayfare
