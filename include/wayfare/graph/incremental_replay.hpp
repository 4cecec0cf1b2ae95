#pragma once

// A graph from a file as it may have grown: edge by edge, each pose with the first edge that
// reaches it.

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
  /// The pose the edge brings in, −1 where it joins two that were there.
  int new_pose = -1;

  /// Where the edge says its new pose is, given the others.
  [[nodiscard]] G placed(const std::vector<G>& poses) const {
    if (new_pose == edge.to) return poses[static_cast<std::size_t>(edge.from)] * edge.measurement;
    return poses[static_cast<std::size_t>(edge.to)] * edge.measurement.inverse();
  }
};

/// The edges of a graph whose poses are numbered in the order of time: by their later pose, and of
/// those that end at the same one, that from the nearest pose first. Pose 0 is there from the
/// start.
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
