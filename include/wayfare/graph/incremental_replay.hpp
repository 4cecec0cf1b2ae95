#pragma once

// Replays a complete graph incrementally: edge by edge, each pose with the first edge that reaches
// it.

#include <algorithm>
#include <cstddef>
#include <cstdlib>
#include <utility>
#include <vector>

#include <wayfare/graph/pose_graph.hpp>

namespace wayfare {

template <LieGroup G>
struct ReplayStep {
  PoseEdge<G> edge;
  /// The pose that the edge adds, −1 if both exist.
  int new_pose = -1;

  /// Initial value of the new pose from the edge.
  [[nodiscard]] G placed(const std::vector<G>& poses) const {
    if (new_pose == edge.to) return poses[static_cast<std::size_t>(edge.from)] * edge.measurement;
    return poses[static_cast<std::size_t>(edge.to)] * edge.measurement.inverse();
  }
};

/// The edges of a graph with poses in temporal order, sorted by their later pose, then by the
/// distance of the indices. Pose 0 exists from the start.
template <LieGroup G>
[[nodiscard]] std::vector<ReplayStep<G>> replay_steps(const PoseGraph<G>& graph) {
  std::vector<ReplayStep<G>> steps;
  for (const auto& edge : graph.edges) steps.push_back({edge});
  const auto key = [](const ReplayStep<G>& step) {
    return std::pair(std::max(step.edge.from, step.edge.to),
                     std::abs(step.edge.from - step.edge.to));
  };
  std::stable_sort(steps.begin(), steps.end(),
                   [&](const auto& a, const auto& b) { return key(a) < key(b); });
  int known = 1;
  for (auto& step : steps)
    if (key(step).first == known) step.new_pose = known++;
  return steps;
}

}  // namespace wayfare
