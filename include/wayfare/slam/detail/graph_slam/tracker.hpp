#pragma once

#include <Eigen/Core>
#include <Eigen/LU>

#include <wayfare/slam/detail/graph_slam/node_map.hpp>
#include <wayfare/slam/detail/graph_slam/placement.hpp>
#include <wayfare/slam/detail/motion.hpp>
#include <wayfare/slam/graph_slam.hpp>

namespace wayfare::detail {

/// Pose of a scan, and whether it required a wider search.
struct Track {
  Placement placement;
  bool widened = false;
};

/// Matches scans to a local map of the latest nodes; how is for `Matching` to say (see
/// FieldMatching and MatcherMatching).
template <class Matching>
class Tracker {
 public:
  Tracker(const GraphSlamOptions& options, const Matching& matching)
      : options_(options), matching_(matching) {}

  /// The scan's pose by the local map; `prior`, predicted by `motion`, if nothing agrees. An Error
  /// is that of a result of the matching that is not valid.
  [[nodiscard]] Result<Track> place(const NodeMap& nodes, const PointSet& points, const SE2d& prior,
                                    const Motion& motion) {
    constexpr std::size_t kFewestPoints = 10;
    if (points.size() < kFewestPoints) return Track{{prior}};
    if (maps_are_old_) matching_.render(nodes);
    maps_are_old_ = false;
    const Eigen::Matrix3d information = motion.covariance().inverse();
    const Eigen::Vector3d reach = (3.0 * motion.sigma).cwiseMin(0.5);
    auto best = matching_.search(points, prior, {reach[0], reach[1], Angle::radians(reach[2])},
                                 information);
    const bool widened = best && best->score < options_.tracked_score;
    if (widened) best = search_wider(nodes, points, prior, information, *best);
    if (!best) return best.error();
    if (best->score < options_.lost_score) return Track{{prior, best->score}, widened};
    const Placement sharp = matching_.refine(points, *best);
    return Track{{settle(sharp, prior, motion), best->score, sharp.spread}, widened};
  }

  /// Of the matching since the last call.
  [[nodiscard]] MatcherErrors take_errors() { return matching_.take_errors(); }

  /// A node was added, or nodes have moved.
  void nodes_changed() { maps_are_old_ = true; }

 private:
  /// First in a wider window at the prediction, then at all headings in a map of all nodes nearby.
  Result<Placement> search_wider(const NodeMap& nodes, const PointSet& points, const SE2d& prior,
                                 const Eigen::Matrix3d& information, Placement best) {
    const auto wide = matching_.search(points, prior, {0.8, 0.8, 50_deg}, 0.25 * information);
    if (!wide) return wide.error();
    if (wide->score > best.score + 0.10) best = *wide;
    if (best.score >= options_.lost_score) return best;
    const auto anywhere = matching_.search_around(nodes, points, prior);
    if (!anywhere) return anywhere.error();
    if (anywhere->score > best.score + 0.30) best = *anywhere;
    return best;
  }

  GraphSlamOptions options_;
  Matching matching_;
  bool maps_are_old_ = true;
};

}  // namespace wayfare::detail
