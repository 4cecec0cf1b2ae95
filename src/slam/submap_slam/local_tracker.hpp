#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include <wayfare/map/probability_grid.hpp>
#include <wayfare/match/gauss_newton.hpp>
#include <wayfare/slam/submap_slam.hpp>

#include "slam/motion.hpp"
#include "slam/submap_slam/submap_graph.hpp"

namespace wayfare {

/// Grids of the unfinished submaps; matches scans to the older of them.
class LocalTracker {
 public:
  explicit LocalTracker(const SubmapSlamOptions& options)
      : options_(options), matcher_(options.match) {}

  /// Pose of points in the local frame: by the match, and by the prediction along unconstrained
  /// directions.
  struct Placement {
    SE2d T_local_points;
    double score = 0.0;
    Eigen::Matrix3d covariance;
    double openness = 0.0;  ///< as LocalPlacement's
  };
  /// Nothing without agreement nearby.
  [[nodiscard]] std::optional<Placement> place(const SubmapGraph& map, const PointSet& points,
                                               const SE2d& T_local_expected,
                                               const Motion& motion) const;

  /// Updates the grids after a node was added, or a submap began or ended.
  Result<void> follow(const SubmapGraph& map);

  [[nodiscard]] std::size_t memory_bytes() const;

 private:
  struct Active {
    std::int64_t id;
    int nodes;  // number inserted
    MultiResolutionGrid grid;
  };

  [[nodiscard]] std::optional<MatchResult> match(const SubmapGraph& map, const PointSet& points,
                                                 const SE2d& T_local_prior,
                                                 const SearchWindow& window,
                                                 const MatchOptions& options) const;
  [[nodiscard]] std::optional<MatchResult> search_wider(const SubmapGraph& map,
                                                        const PointSet& points,
                                                        const SE2d& T_local_expected,
                                                        const Motion& motion) const;

  SubmapSlamOptions options_;
  GaussNewtonMatcher matcher_;
  std::vector<Active> active_;  // as the graph's unfinished submaps
};

/// The unfinished submap that scans are matched to.
[[nodiscard]] const Submap& matched_submap(const SubmapGraph& map);

}  // namespace wayfare
