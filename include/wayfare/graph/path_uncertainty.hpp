#pragma once

// How well a pose graph knows where its poses are relative to one of them, without factorising it.

#include <cstddef>
#include <functional>
#include <limits>
#include <queue>
#include <utility>
#include <vector>

#include <Eigen/LU>

#include <wayfare/graph/pose_graph.hpp>

namespace wayfare {

/// The covariance of X_root⁻¹ X_k along the least uncertain chain of edges from `root` to each pose
/// k, as a right perturbation of it. The chain leaves all other edges out, so the true covariance
/// is smaller: a safe bound for gates and search windows (Olson 2008, "Robust and efficient robotic
/// mapping", section 5.2).
struct PathUncertainty {
  /// The size of an uncertainty is var x + var y + kLever² var θ.
  static constexpr double kLever_m = 2.0;

  std::vector<Eigen::Matrix3d> covariance;  ///< one a pose; undefined where not reached
  std::vector<double> size;                 ///< m²; infinite where not reached

  [[nodiscard]] bool reached(int pose) const {
    return size[static_cast<std::size_t>(pose)] < std::numeric_limits<double>::infinity();
  }
};

/// Edges for which `usable(edge)` is false are left out. Dijkstra's search, O(E log V); information
/// matrices must be positive definite.
template <class Usable>
[[nodiscard]] PathUncertainty path_uncertainty(const PoseGraph2& graph, int root, Usable usable) {
  const auto n = graph.poses.size();
  std::vector<std::vector<std::pair<int, int>>> neighbours(n);  // (pose, edge)
  for (std::size_t k = 0; k < graph.edges.size(); ++k) {
    const auto& e = graph.edges[k];
    if (!usable(e)) continue;
    neighbours[static_cast<std::size_t>(e.from)].emplace_back(e.to, static_cast<int>(k));
    neighbours[static_cast<std::size_t>(e.to)].emplace_back(e.from, static_cast<int>(k));
  }

  PathUncertainty result;
  result.covariance.assign(n, Eigen::Matrix3d::Zero());
  result.size.assign(n, std::numeric_limits<double>::infinity());
  result.size[static_cast<std::size_t>(root)] = 0.0;
  using Entry = std::pair<double, int>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
  open.emplace(0.0, root);
  while (!open.empty()) {
    const auto [size, pose] = open.top();
    open.pop();
    const auto at = static_cast<std::size_t>(pose);
    if (size > result.size[at]) continue;
    for (const auto& [next, edge] : neighbours[at]) {
      const auto to = static_cast<std::size_t>(next);
      const auto& e = graph.edges[static_cast<std::size_t>(edge)];
      const SE2d step = graph.poses[at].inverse() * graph.poses[to];
      const Eigen::Matrix3d move = step.inverse().adjoint();
      Eigen::Matrix3d own = e.information.inverse();
      if (e.from != pose) own = move * own * move.transpose();  // the edge is walked backwards
      const Eigen::Matrix3d sum = move * result.covariance[at] * move.transpose() + own;
      const double sum_size =
          sum(0, 0) + sum(1, 1) + PathUncertainty::kLever_m * PathUncertainty::kLever_m * sum(2, 2);
      if (!(sum_size < result.size[to])) continue;
      result.size[to] = sum_size;
      result.covariance[to] = sum;
      open.emplace(sum_size, next);
    }
  }
  return result;
}

}  // namespace wayfare
