#pragma once

// What the systems with a pose graph share: its edges, loop closures, optimisation and trajectory.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <vector>

#include <wayfare/graph/optimise.hpp>
#include <wayfare/graph/path_uncertainty.hpp>
#include <wayfare/match/scan_matcher.hpp>
#include <wayfare/slam/detail/motion.hpp>
#include <wayfare/slam/detail/scans.hpp>

namespace wayfare {

/// A scan's pose relative to its node.
struct ScanPose {
  LogTime time;
  int node = 0;
  SE2d T_node_base;
};

/// The edge of a candidate for a loop, if it is one; an Error of the matcher.
using LoopMatch = Result<std::optional<PoseEdge<SE2d>>>;

/// Result of a search for loops.
struct Loops {
  std::vector<PoseEdge<SE2d>> edges;
  std::size_t refused = 0;  ///< candidates matched and rejected
  MatcherErrors errors;     ///< of these candidates

  Loops() = default;
  explicit Loops(const std::vector<LoopMatch>& matches) {
    for (const LoopMatch& match : matches) {
      if (!match)
        errors.add(match.error());
      else if (*match)
        edges.push_back(**match);
    }
    refused = matches.size() - edges.size();
  }
};

/// Robust kernel of loop closures.
[[nodiscard]] inline RobustKernel loop_kernel(double sigmas) {
  return {RobustKernelKind::cauchy, sigmas};
}

/// Whether a graph at its poses agrees with an edge.
[[nodiscard]] inline bool agrees(const PoseGraph2& graph, const PoseEdge<SE2d>& edge,
                                 const RobustKernel& kernel) {
  return !edge.robust || kernel(squared_error(graph, edge)).weight > 0.3;
}

/// From a pose of the graph over the edges on which it agrees, until `settled(pose)`.
template <class Settled>
[[nodiscard]] const PathUncertainty& uncertainty_from(int pose, const PoseGraph2& graph,
                                                      const RobustKernel& kernel,
                                                      PathUncertaintyFinder& finder,
                                                      const Settled& settled) {
  return finder.find(
      graph, pose, [&](const PoseEdge<SE2d>& edge) { return agrees(graph, edge, kernel); },
      settled);
}
/// The same to all poses.
[[nodiscard]] inline const PathUncertainty& uncertainty_from(int pose, const PoseGraph2& graph,
                                                             const RobustKernel& kernel,
                                                             PathUncertaintyFinder& finder) {
  return uncertainty_from(pose, graph, kernel, finder, [](int) { return false; });
}

/// Three standard deviations of the position along its less certain axis.
[[nodiscard]] inline double reach_m(const Eigen::Matrix3d& covariance) {
  return 3.0 * std::sqrt(std::max(covariance(0, 0), covariance(1, 1)));
}

/// Of the search for a loop at a pose of this covariance.
[[nodiscard]] inline SearchWindow loop_window(const Eigen::Matrix3d& covariance, double largest_m) {
  const double reach = std::clamp(reach_m(covariance), 0.3, largest_m);
  const double turn = std::clamp(3.0 * std::sqrt(covariance(2, 2)), Angle::degrees(4).radians(),
                                 Angle::degrees(90).radians());
  return {reach, reach, Angle::radians(turn)};
}

/// Of the edge to a node that no match has placed.
[[nodiscard]] inline Eigen::Matrix3d weak_information(double travel_m, double turn_rad) {
  const double sigma_m = 0.1 + 0.3 * travel_m;
  return information_of({sigma_m, sigma_m, Angle::degrees(10).radians() + 0.5 * turn_rad});
}

/// Counts the optimisations that succeed; otherwise the poses stay.
template <class Optimiser>
Result<void> optimise(Optimiser& optimiser, PoseGraph2& graph, const RobustKernel& kernel,
                      int iterations, double min_gain, std::size_t& count) {
  OptimiseOptions options;
  options.kernel = kernel;
  options.max_iterations = iterations;
  options.min_relative_gain = min_gain;
  const auto report = optimiser.optimise(graph, options);
  if (!report) return report.error();
  ++count;
  return {};
}

}  // namespace wayfare
