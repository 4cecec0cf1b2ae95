#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include <wayfare/graph/path_uncertainty.hpp>
#include <wayfare/graph/robust_kernel.hpp>
#include <wayfare/match/scan_matcher.hpp>
#include <wayfare/slam/graph_slam.hpp>

#include "slam/graph_slam/node_map.hpp"

namespace wayfare {

/// Result of a search for loops.
struct Loops {
  std::vector<PoseEdge<SE2d>> edges;  ///< from older nodes to the latest
  std::size_t refused = 0;            ///< candidates matched and rejected
};

/// Finds older nodes that share a view with the latest node.
class LoopCloser {
 public:
  explicit LoopCloser(const GraphSlamOptions& options) : options_(options) {}

  /// Searches at intervals of `nodes_between_loops`; returns nothing otherwise.
  [[nodiscard]] Loops search(const NodeMap& nodes);

  /// Robust kernel of loop closures.
  [[nodiscard]] RobustKernel kernel() const {
    return {RobustKernelKind::cauchy, options_.loop_kernel_sigmas};
  }

 private:
  struct Candidate {
    int node = 0;
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  // of the latest node relative to it
  };

  [[nodiscard]] std::vector<Candidate> candidates(const NodeMap& nodes);
  [[nodiscard]] bool may_share_view(const NodeMap& nodes, const PathUncertainty& known,
                                    int k) const;
  [[nodiscard]] PointSet context(const NodeMap& nodes) const;
  [[nodiscard]] std::optional<PoseEdge<SE2d>> match(const NodeMap& nodes,
                                                    const Candidate& candidate,
                                                    const PointSet& context) const;
  [[nodiscard]] SearchWindow window(const Candidate& candidate) const;
  [[nodiscard]] std::optional<SE2d> find(std::span<const PlacedPoints> around,
                                         const PointSet& context, const SE2d& prior,
                                         const SearchWindow& window) const;

  GraphSlamOptions options_;
  PathUncertaintyFinder uncertainty_;
  int last_searched_ = 0;
};

}  // namespace wayfare
