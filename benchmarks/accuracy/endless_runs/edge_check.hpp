#pragma once

// The edges of a pose graph against the true poses: whether their information fits their errors.

#include <cstddef>
#include <vector>

#include <wayfare/graph/pose_graph.hpp>
#include <wayfare/sensors/trajectory.hpp>

namespace wayfare {

/// Normalised squared errors of edges with the true poses.
struct EdgeErrors {
  std::vector<double> chi2 = {};  ///< eᵀΩe; in the mean 3 where Ω is right

  [[nodiscard]] double mean() const;
  [[nodiscard]] double median() const;
  /// Edges above this value.
  [[nodiscard]] std::size_t above(double limit) const;
};

/// Of the robust edges, loops and what is made of them at merging, or of the others. A node is the
/// scan whose estimated pose is the node's; edges of a node without one are left out. `truth` and
/// `estimate` have one pose for each scan.
[[nodiscard]] EdgeErrors edge_errors(const PoseGraph2& graph, bool robust,
                                     const Trajectory& estimate, const Trajectory& truth);

}  // namespace wayfare
