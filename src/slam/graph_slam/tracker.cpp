#include "slam/graph_slam/tracker.hpp"

#include <Eigen/LU>

#include "slam/graph_slam/ambiguity.hpp"

namespace wayfare {

Track Tracker::place(const NodeMap& nodes, const PointSet& points, const SE2d& prior,
                     const Motion& motion) {
  constexpr std::size_t kFewestPoints = 10;
  if (points.size() < kFewestPoints) return {{prior}};
  if (maps_are_old_) render(nodes);
  const Eigen::Matrix3d information = motion.covariance().inverse();
  const Eigen::Vector3d reach = (3.0 * motion.sigma).cwiseMin(0.5);
  Placement best = search_map_.search(points, prior, {reach[0], reach[1], Angle::radians(reach[2])},
                                      information);
  const bool widened = best.score < options_.tracked_score;
  if (widened) best = search_wider(nodes, points, prior, information, best);
  if (best.score < options_.lost_score) return {{prior, best.score}, widened};
  const Placement sharp = sharp_map_.refine(points, best.T_map_points);
  return {{settle(sharp, prior, motion), best.score, sharp.spread}, widened};
}

/// First in a wider window at the prediction, then at all headings in a map of all nodes nearby.
Placement Tracker::search_wider(const NodeMap& nodes, const PointSet& points, const SE2d& prior,
                                const Eigen::Matrix3d& information, Placement best) {
  const auto better = [&best](const Placement& other, double margin) {
    if (other.score > best.score + margin) best = other;
  };
  better(search_map_.search(points, prior, {0.8, 0.8, 50_deg}, 0.25 * information), 0.10);
  if (best.score >= options_.lost_score) return best;
  LocalMap around;
  around.render(nodes.around(prior, 4.0, 80), options_.cell_m, options_.search_sigma_m);
  const Eigen::Matrix3d loose =
      Eigen::Vector3d(0.5, 0.5, 1.0).cwiseAbs2().cwiseInverse().asDiagonal();
  better(around.search(points, prior, {1.0, 1.0, 180_deg}, loose), 0.30);
  return best;
}

void Tracker::render(const NodeMap& nodes) {
  const int latest = nodes.latest();
  const auto last = [&](int count) {
    return nodes.chain(latest - count + 1, latest, options_.local_radius_m);
  };
  search_map_.render(last(options_.local_nodes), options_.cell_m, options_.search_sigma_m);
  sharp_map_.render(last(options_.sharp_nodes), options_.cell_m, options_.sharp_sigma_m);
  maps_are_old_ = false;
}

}  // namespace wayfare
