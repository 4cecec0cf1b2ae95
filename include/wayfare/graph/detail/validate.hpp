#pragma once

// Validation of a pose graph before any computation; errors name the pose or edge. Compiled in
// wayfare::graph for SE2d and SE3d.

#include <cmath>
#include <cstddef>
#include <functional>
#include <numeric>
#include <string>
#include <type_traits>
#include <vector>

#include <wayfare/core/result.hpp>
#include <wayfare/graph/pose_graph.hpp>

namespace wayfare {

namespace detail {

inline bool is_finite(const SE2d& x) {
  return x.translation().allFinite() && std::isfinite(x.rotation().cos() + x.rotation().sin());
}
inline bool is_finite(const SE3d& x) {
  return x.translation().allFinite() && x.rotation().quaternion().coeffs().allFinite();
}

/// Union-find over pose indices.
class Components {
 public:
  explicit Components(int size) : parent_(static_cast<std::size_t>(size)) {
    std::iota(parent_.begin(), parent_.end(), 0);
  }
  int root(int i) {
    while (at(i) != i) i = at(i) = at(at(i));
    return i;
  }
  void join(int a, int b) { at(root(a)) = root(b); }

 private:
  int& at(int i) { return parent_[static_cast<std::size_t>(i)]; }
  std::vector<int> parent_;
};

}  // namespace detail

/// Success if the graph can be optimised; otherwise the first fault, by pose or edge.
template <LieGroup G>
[[nodiscard]] Result<void> validate(const PoseGraph<G>& graph);

/// The first fault of edge `index`, or success.
template <LieGroup G>
[[nodiscard]] Result<void> validate_edge(const PoseGraph<G>& graph, std::size_t index);

/// Every pose must be connected to a fixed one by edges for which `counts(edge)`; `how` describes
/// those edges in the message.
template <LieGroup G>
[[nodiscard]] Result<void> validate_connection(
    const PoseGraph<G>& graph,
    const std::type_identity_t<std::function<bool(const PoseEdge<G>&)>>& counts,
    const std::string& how);

/// Names the edge that makes the cost of a valid graph overflow.
template <LieGroup G>
[[nodiscard]] Error cost_overflow(const PoseGraph<G>& graph);

}  // namespace wayfare
