#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include <wayfare/map/multi_resolution_grid.hpp>
#include <wayfare/match/gauss_newton.hpp>
#include <wayfare/slam/submap_slam.hpp>

#include "slam/motion.hpp"
#include "slam/submap_slam/submap_graph.hpp"

namespace wayfare {

/// Grids of the unfinished submaps, and scans placed in the older of them.
class LocalTracker {
 public:
  explicit LocalTracker(const SubmapSlamOptions& options)
      : options_(options), matcher_(options.match) {}

  /// Where points are in the local frame: by match, and by motion along what the scene leaves open.
  struct Placement {
    SE2d T_local_points;
    double score = 0.0;
    Eigen::Matrix3d covariance;
    double openness = 0.0;  ///< as LocalPlacement's
  };
  /// None where nothing near agrees.
  [[nodiscard]] std::optional<Placement> place(const SubmapGraph& map, const PointSet& points,
                                               const SE2d& T_local_expected,
                                               const Motion& motion) const;

  /// The latest node has come, or a submap has begun or ended: the grids follow.
  Result<void> follow(const SubmapGraph& map);

  [[nodiscard]] std::size_t memory_bytes() const;

 private:
  struct Active {
    std::int64_t id;
    int nodes;  // in it
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
