#pragma once

#include <Eigen/Core>

#include <wayfare/slam/graph_slam.hpp>

#include "slam/graph_slam/local_map.hpp"
#include "slam/graph_slam/node_map.hpp"
#include "slam/motion.hpp"

namespace wayfare {

/// Pose of a scan, and whether it required a wider search.
struct Track {
  Placement placement;
  bool widened = false;
};

/// Matches scans to a local map of the latest nodes.
class Tracker {
 public:
  explicit Tracker(const GraphSlamOptions& options) : options_(options) {}

  /// The scan's pose by the local map; `prior`, predicted by `motion`, if nothing agrees.
  [[nodiscard]] Track place(const NodeMap& nodes, const PointSet& points, const SE2d& prior,
                            const Motion& motion);

  /// A node was added, or nodes have moved.
  void nodes_changed() { maps_are_old_ = true; }

 private:
  void render(const NodeMap& nodes);
  [[nodiscard]] Placement search_wider(const NodeMap& nodes, const PointSet& points,
                                       const SE2d& prior, const Eigen::Matrix3d& information,
                                       Placement best);

  GraphSlamOptions options_;
  LocalMap search_map_, sharp_map_;
  bool maps_are_old_ = true;
};

}  // namespace wayfare
