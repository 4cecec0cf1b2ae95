#pragma once

#include <Eigen/Core>
#include <Eigen/LU>

#include <wayfare/slam/detail/motion.hpp>
#include <wayfare/slam/graph_slam.hpp>

#include "slam/graph_slam/local_map.hpp"
#include "slam/graph_slam/node_map.hpp"

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
                            const Motion& motion) {
    constexpr std::size_t kFewestPoints = 10;
    if (points.size() < kFewestPoints) return {{prior}};
    if (maps_are_old_) render(nodes);
    const Eigen::Matrix3d information = motion.covariance().inverse();
    const Eigen::Vector3d reach = (3.0 * motion.sigma).cwiseMin(0.5);
    Placement best = search_map_.search(
        points, prior, {reach[0], reach[1], Angle::radians(reach[2])}, information);
    const bool widened = best.score < options_.tracked_score;
    if (widened) best = search_wider(nodes, points, prior, information, best);
    if (best.score < options_.lost_score) return {{prior, best.score}, widened};
    const Placement sharp = sharp_map_.refine(points, best.T_map_points);
    return {{settle(sharp, prior, motion), best.score, sharp.spread}, widened};
  }

  /// A node was added, or nodes have moved.
  void nodes_changed() { maps_are_old_ = true; }

 private:
  /// First in a wider window at the prediction, then at all headings in a map of all nodes nearby.
  Placement search_wider(const NodeMap& nodes, const PointSet& points, const SE2d& prior,
                         const Eigen::Matrix3d& information, Placement best) {
    const auto better = [&best](const Placement& other, double margin) {
      if (other.score > best.score + margin) best = other;
    };
    better(search_map_.search(points, prior, {0.8, 0.8, 50_deg}, 0.25 * information), 0.10);
    if (best.score >= options_.lost_score) return best;
    LocalMap around;
    around.render(nodes.around(prior, 4.0, 80), options_.cell_m, options_.search_sigma_m);
    better(around.search(points, prior, {1.0, 1.0, 180_deg}, information_of({0.5, 0.5, 1.0})),
           0.30);
    return best;
  }

  void render(const NodeMap& nodes) {
    const int latest = nodes.latest();
    const auto last = [&](int count) {
      return nodes.chain(latest - count + 1, latest, options_.local_radius_m);
    };
    search_map_.render(last(options_.local_nodes), options_.cell_m, options_.search_sigma_m);
    sharp_map_.render(last(options_.sharp_nodes), options_.cell_m, options_.sharp_sigma_m);
    maps_are_old_ = false;
  }

  GraphSlamOptions options_;
  LocalMap search_map_, sharp_map_;
  bool maps_are_old_ = true;
};

}  // namespace wayfare
