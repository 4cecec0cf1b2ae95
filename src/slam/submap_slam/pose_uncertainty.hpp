#pragma once

#include <array>
#include <cstddef>
#include <limits>
#include <vector>

#include <Eigen/Core>
#include <Eigen/LU>

#include <wayfare/slam/detail/loops.hpp>
#include <wayfare/slam/submap_slam.hpp>

#include "slam/matched.hpp"
#include "slam/submap_slam/submap_graph.hpp"

namespace wayfare {

/// Of the reference of a match over a distance, with which its error grows, in the graph.
[[nodiscard]] inline Eigen::Matrix3d reference_covariance(double length_m, double turn_rad) {
  const double sigma_m = 0.02 + 0.02 * length_m;
  const double sigma_rad =
      Angle::degrees(0.4).radians() + 0.02 * turn_rad + Angle::degrees(0.2).radians() * length_m;
  return Eigen::Vector3d(sigma_m, sigma_m, sigma_rad).cwiseAbs2().asDiagonal();
}
[[nodiscard]] inline Eigen::Matrix3d match_information(const Eigen::Matrix3d& matched,
                                                       double length_m, double turn_rad) {
  return (matched + reference_covariance(length_m, turn_rad)).inverse();
}

/// The covariance of the latest node relative to an earlier one. A node is known to its submap by
/// the drift of the path since the submap began, and along directions that the scene leaves open by
/// its match; the edges of the graph are too cautious for that, as each of them counts alone along
/// a chain. Loops, and nodes that no match has placed, have the covariance of their edges.
class PoseUncertainty {
 public:
  explicit PoseUncertainty(const SubmapSlamOptions& options)
      : drift_(options.drift), kernel_(loop_kernel(options.loop_kernel_sigmas)) {}

  /// Of `first` and the latest node; found again where `changes`, counts of what changes the map,
  /// have grown.
  [[nodiscard]] const Eigen::Matrix3d& of_latest(const SubmapGraph& map, int first,
                                                 const std::array<std::size_t, 3>& changes) {
    if (changes == found_at_) return found_;
    found_at_ = changes;
    finder_.forget();
    const PathUncertainty& known =
        uncertainty_from(map.node(first).pose, by_drift(map), kernel_, finder_);
    const int latest = map.nodes.back().pose;
    found_ = known.reached(latest) ? known.covariance[static_cast<std::size_t>(latest)]
                                   : unknown_covariance();
    return found_;
  }

 private:
  [[nodiscard]] PoseGraph2 by_drift(const SubmapGraph& map) const {
    PoseGraph2 graph = map.graph;
    constexpr double kLeast = 1e-6;  // to the millimetre
    constexpr double kNode = std::numeric_limits<double>::infinity();
    std::vector<double> began_m(graph.poses.size(), kNode), travel_m(graph.poses.size(), 0.0);
    for (const SubmapNode& n : map.nodes) travel_m[static_cast<std::size_t>(n.pose)] = n.travel_m;
    for (const Submap& s : map.submaps)
      began_m[static_cast<std::size_t>(s.pose)] = map.node(s.first).travel_m;
    for (PoseEdge<SE2d>& e : graph.edges) {
      const double since_m =
          travel_m[static_cast<std::size_t>(e.to)] - began_m[static_cast<std::size_t>(e.from)];
      if (e.robust || !(since_m > 0.0)) continue;
      const Eigen::Matrix3d matched = e.information.inverse() - reference_covariance(since_m, 0.0);
      e.information = (drift_.covariance(since_m) + lasting_covariance(matched) +
                       kLeast * Eigen::Matrix3d::Identity())
                          .inverse();
    }
    return graph;
  }

  PathDrift drift_;
  RobustKernel kernel_;
  PathUncertaintyFinder finder_;
  std::array<std::size_t, 3> found_at_{};
  Eigen::Matrix3d found_ = Eigen::Matrix3d::Zero();
};

}  // namespace wayfare
