#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include <wayfare/core/manifold.hpp>
#include <wayfare/core/result.hpp>
#include <wayfare/graph/pose_error.hpp>
#include <wayfare/graph/robust_kernel.hpp>

namespace wayfare {

/// A measurement of pose `to` in the frame of pose `from`, with information Ω (the inverse of the
/// covariance) of the error defined by PoseError.
template <LieGroup G>
struct PoseEdge {
  int from = 0;
  int to = 0;
  G measurement{};
  SquareOf<G> information = SquareOf<G>::Identity();
  /// Whether the robust kernel applies: true for possible outliers (loop closures), false for
  /// measurements that are only noisy (odometry).
  bool robust = false;
};

/// Poses and relative measurements between them. A plain value: poses and edges may be appended at
/// any time.
template <LieGroup G>
struct PoseGraph {
  std::vector<G> poses;  ///< in one common frame; initial values of the next optimisation
  std::vector<PoseEdge<G>> edges;
  std::vector<int> fixed;           ///< fixed poses; empty: pose 0
  std::vector<std::string> labels;  ///< names of the poses in messages; empty: their indices

  /// Returns the new pose's index.
  int add_pose(const G& pose) {
    poses.push_back(pose);
    return size() - 1;
  }
  [[nodiscard]] int size() const { return static_cast<int>(poses.size()); }
  [[nodiscard]] std::string label(int pose) const {
    const auto i = static_cast<std::size_t>(pose);
    return pose >= 0 && i < labels.size() ? labels[i] : std::to_string(pose);
  }
};

using PoseGraph2 = PoseGraph<SE2d>;
using PoseGraph3 = PoseGraph<SE3d>;

/// eᵀΩe as computed, without what rounding may have taken below zero: Ω is positive semi-definite,
/// so that zero is nearer to the truth than any negative number. NaN stays.
[[nodiscard]] inline double not_negative(double square) { return square < 0.0 ? 0.0 : square; }

/// eᵀΩe of one edge at the graph's poses.
template <LieGroup G>
[[nodiscard]] double squared_error(const PoseGraph<G>& graph, const PoseEdge<G>& edge) {
  const auto e =
      PoseError<G>::error(edge.measurement, graph.poses[static_cast<std::size_t>(edge.from)],
                          graph.poses[static_cast<std::size_t>(edge.to)]);
  return not_negative(e.dot(edge.information * e));
}

/// Σ eᵀΩe over all edges, without a factor of ½ and without robust kernels.
template <LieGroup G>
[[nodiscard]] double chi2(const PoseGraph<G>& graph) {
  double sum = 0.0;
  for (const auto& edge : graph.edges) sum += squared_error(graph, edge);
  return sum;
}

/// Σ ρ(eᵀΩe): the optimiser's objective; equal to chi2 without a kernel.
template <LieGroup G>
[[nodiscard]] double robust_cost(const PoseGraph<G>& graph, const RobustKernel& kernel) {
  double sum = 0.0;
  for (const auto& edge : graph.edges) {
    const double s = squared_error(graph, edge);
    sum += edge.robust ? kernel(s).cost : s;
  }
  return sum;
}

// Compiled once in wayfare::graph.
extern template double squared_error(const PoseGraph<SE2d>&, const PoseEdge<SE2d>&);
extern template double squared_error(const PoseGraph<SE3d>&, const PoseEdge<SE3d>&);
extern template double chi2(const PoseGraph<SE2d>&);
extern template double chi2(const PoseGraph<SE3d>&);
extern template double robust_cost(const PoseGraph<SE2d>&, const RobustKernel&);
extern template double robust_cost(const PoseGraph<SE3d>&, const RobustKernel&);

}  // namespace wayfare
