#pragma once

#include <cstddef>
#include <vector>

#include <wayfare/core/result.hpp>
#include <wayfare/graph/optimise.hpp>
#include <wayfare/graph/pose_graph.hpp>

namespace wayfare::detail {

/// Optimises a large graph where it was changed: the poses within a number of edges of one, with
/// the others fixed. Where poses next to these move by more than 1 cm or 0.1°, more are optimised,
/// in the end all. A small correction of a long path is thus not spread over all of it.
class LocalOptimiser {
 public:
  /// The pose about which the next calls optimise.
  LocalOptimiser& around(int pose) {
    pose_ = pose;
    return *this;
  }
  /// The next calls optimise all poses. The map as a whole stays where it is, by least squares,
  /// instead of the pose held: one with few edges may be the least certain of all, and the map
  /// would turn about it.
  LocalOptimiser& everywhere() { return around(kNowhere); }
  /// Errors as those of GraphOptimiser, with the poses unchanged.
  Result<void> optimise(PoseGraph2& graph, const OptimiseOptions& options);

 private:
  void link(const PoseGraph2& graph);
  bool select(const PoseGraph2& graph, std::size_t most);
  Result<void> optimise_region(PoseGraph2& graph, const OptimiseOptions& options);
  [[nodiscard]] bool border_has_moved(const PoseGraph2& graph,
                                      const std::vector<SE2d>& before) const;

  Result<void> optimise_whole(PoseGraph2& graph, const OptimiseOptions& options);

  static constexpr int kNowhere = -1;

  int pose_ = 0;
  std::vector<int> first_, edges_;  // of each pose: its first entry among `edges_`
  std::vector<int> region_;         // poses, the free ones first
  std::size_t free_ = 0;
  std::vector<int> local_;  // of each pose: its number in the region, or −1
  PoseGraph2 part_;
  PoseGraphOptimiser<SE2d> optimiser_, whole_;
};

}  // namespace wayfare::detail
