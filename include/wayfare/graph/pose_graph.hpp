#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include <wayfare/core/manifold.hpp>
#include <wayfare/core/result.hpp>
#include <wayfare/graph/pose_error.hpp>
#include <wayfare/graph/robust_kernel.hpp>

namespace wayfare {

/// "Pose `to` was seen from pose `from` at `measurement`", with information Ω (the inverse of the
/// covariance) of the error that PoseError defines.
template <LieGroup G>
struct PoseEdge {
  int from = 0;
  int to = 0;
  G measurement{};
  SquareOf<G> information = SquareOf<G>::Identity();
  /// Whether a robust kernel, where one is chosen, applies: true for what may be plain wrong (a
  /// loop closure), false for what may only be noisy (odometry).
  bool robust = false;
};

/// Poses and relative measurements between them. A plain value: append poses and edges as they
/// come, optimise when it suits.
template <LieGroup G>
struct PoseGraph {
  std::vector<G> poses;  ///< in one common frame; the start of the next optimisation
  std::vector<PoseEdge<G>> edges;
  std::vector<int> fixed;           ///< poses held where they are; none named: pose 0
  std::vector<std::string> labels;  ///< what messages call the poses; empty: their indices

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

/// eᵀΩe as computed, without what rounding may have taken below zero: Ω is positive semi-definite, so
/// that zero is nearer to the truth than any negative number. NaN stays.
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

/// Σ ρ(eᵀΩe): what the optimiser lowers; equal to chi2 where no kernel applies.
template <LieGroup G>
[[nodiscard]] double robust_cost(const PoseGraph<G>& graph, const RobustKernel& kernel) {
  double sum = 0.0;
  for (const auto& edge : graph.edges) {
    const double s = squared_error(graph, edge);
    sum += edge.robust ? kernel(s).cost : s;
  }
  return sum;
}

// Compiled once in wayfare::slam.
extern template double squared_error(const PoseGraph<SE2d>&, const PoseEdge<SE2d>&);
extern template double squared_error(const PoseGraph<SE3d>&, const PoseEdge<SE3d>&);
extern template double chi2(const PoseGraph<SE2d>&);
extern template double chi2(const PoseGraph<SE3d>&);
extern template double robust_cost(const PoseGraph<SE2d>&, const RobustKernel&);
extern template double robust_cost(const PoseGraph<SE3d>&, const RobustKernel&);

}  // namespace wayfare
