#pragma once

// Validation of a pose graph before any computation; errors name the pose or edge. Compiled in
// wayfare::graph for SE2d and SE3d.

#include <cmath>
#include <cstddef>
#include <functional>
#include <numeric>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

#include <wayfare/core/result.hpp>
#include <wayfare/graph/factor_graph.hpp>
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

namespace detail {

/// Success if it is finite, not zero, symmetric, and positive semi-definite to rounding; else
/// "has zero information", for an edge.
[[nodiscard]] Result<void> check_information(const Eigen::Ref<const Eigen::MatrixXd>& information);

/// "edge 3 (1, 7) has …"; edges are counted type by type.
[[nodiscard]] Error edge_fault(int index, std::span<const int> variables, ErrorCode code,
                               const std::string& what);

}  // namespace detail

/// The values of the variables are finite where ManifoldTraits can tell, and the edges' information
/// is that of a measurement. Whether every variable is determined is left to the factorisation.
template <class V, class E>
[[nodiscard]] Result<void> validate(const FactorGraph<V, E>& graph) {
  if (graph.size() == 0) return Error{ErrorCode::degenerate, "the graph has no variables"};
  Result<void> first;
  int index = 0;
  graph.each_edge([&]<class X>(const X& edge, const auto& variables, const auto&...) {
    if constexpr (detail::kHasInformation<X>) {
      if (first) {
        const auto checked = detail::check_information(edge.information);
        if (!checked)
          first =
              detail::edge_fault(index, variables, checked.error().code, checked.error().message);
      }
    }
    ++index;
  });
  return first;
}

/// Names the edge that makes the cost or the gradient of a valid graph not finite.
template <class V, class E>
[[nodiscard]] Error cost_overflow(const FactorGraph<V, E>& graph) {
  Result<void> first;
  int index = 0;
  graph.each_edge([&]<class X>(const X& edge, const auto& variables, const auto&... x) {
    const auto fault = [&](ErrorCode code, const char* what) {
      if (first) first = detail::edge_fault(index, variables, code, what);
    };
    JacobiansOf<X> jacobians;
    if (!EdgeError<X>(linearise(edge, jacobians, x...)).allFinite())
      fault(ErrorCode::invalid, "has an error that is not finite");
    else if (!std::isfinite(squared_error(edge, x...)))
      fault(ErrorCode::degenerate, "has an error too large to square");
    if (!std::apply([](const auto&... by) { return (by.allFinite() && ...); }, jacobians.by))
      fault(ErrorCode::invalid, "has a Jacobian that is not finite");
    ++index;
  });
  if (!first) return first.error();
  return {ErrorCode::degenerate, "the sum of the edges' squared errors overflows"};
}

}  // namespace wayfare
