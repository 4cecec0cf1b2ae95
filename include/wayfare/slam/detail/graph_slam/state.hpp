#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include <wayfare/core/result.hpp>
#include <wayfare/slam/detail/graph_slam/loss_detector.hpp>
#include <wayfare/slam/detail/graph_slam/node_map.hpp>
#include <wayfare/slam/detail/loops.hpp>
#include <wayfare/slam/detail/motion.hpp>
#include <wayfare/slam/graph_slam.hpp>

namespace wayfare::detail {

/// All that a graph SLAM keeps between scans.
struct GraphSlamState {
  NodeMap& nodes;
  MotionModel& motion;
  LossDetector& loss;
  std::vector<ScanPose>& scans;
  SE2d& pose;
  Eigen::Matrix3d& since_node;
  GraphSlamStatistics& statistics;
  int &last_searched, &kept;  ///< nodes
  double& usual_sharp;        ///< score of usual scans in the refinement map
};

/// As bytes.
[[nodiscard]] std::vector<std::uint8_t> save(GraphSlamState state);
/// Errors: another format, damage, values that no map has; the state is then to be discarded.
[[nodiscard]] Result<void> restore(GraphSlamState state, std::span<const std::uint8_t> bytes);

}  // namespace wayfare::detail
