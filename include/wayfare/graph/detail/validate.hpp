#pragma once

// Validation of a pose graph before any computation; errors name the pose or edge.

#include <cmath>
#include <cstddef>
#include <numeric>
#include <string>
#include <vector>

#include <Eigen/Cholesky>

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

/// Positive semi-definite to rounding: zero information in a direction is valid, negative
/// information is not.
template <int N>
bool is_semidefinite(const Eigen::Matrix<double, N, N>& m) {
  using Square = Eigen::Matrix<double, N, N>;
  // The diagonal is raised by the rounding error of the eigenvalues. LDLᵀ is unsuitable: pivots of
  // a singular matrix are rounding errors, on which it can fail.
  const double rounding = 1e-12 * m.cwiseAbs().maxCoeff();
  if (rounding == 0.0) return true;
  // Gershgorin: every eigenvalue is at least a diagonal entry minus the rest of its row.
  const auto rest = m.cwiseAbs().rowwise().sum() - m.diagonal().cwiseAbs();
  if ((m.diagonal() - rest).minCoeff() >= 0.0) return true;
  return Eigen::LLT<Square>(m + rounding * Square::Identity()).info() == Eigen::Success;
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

template <LieGroup G>
Error edge_fault(const PoseGraph<G>& graph, std::size_t index, ErrorCode code,
                 const std::string& what) {
  const PoseEdge<G>& edge = graph.edges[index];
  return {code, "edge " + std::to_string(index) + " (" + graph.label(edge.from) + " -> " +
                    graph.label(edge.to) + ") " + what};
}

}  // namespace detail

/// The first fault of edge `index` except for its information, or success.
template <LieGroup G>
[[nodiscard]] Result<void> validate_ends(const PoseGraph<G>& graph, std::size_t index) {
  const PoseEdge<G>& edge = graph.edges[index];
  for (const int end : {edge.from, edge.to}) {
    if (end >= 0 && end < graph.size()) continue;
    return detail::edge_fault(
        graph, index, ErrorCode::not_found,
        "names pose " + std::to_string(end) + ", which the graph does not have");
  }
  if (edge.from == edge.to)
    return detail::edge_fault(graph, index, ErrorCode::invalid, "joins a pose to itself");
  if (detail::is_finite(edge.measurement)) return {};
  return detail::edge_fault(graph, index, ErrorCode::invalid,
                            "has a measurement that is not finite");
}

/// The first fault of the information of edge `index`, or success.
template <LieGroup G>
[[nodiscard]] Result<void> validate_information(const PoseGraph<G>& graph, std::size_t index) {
  const auto fault = [&](ErrorCode code, const char* what) {
    return detail::edge_fault(graph, index, code, what);
  };
  const SquareOf<G>& info = graph.edges[index].information;
  if (!info.allFinite()) return fault(ErrorCode::invalid, "has an information that is not finite");
  const double size = info.cwiseAbs().maxCoeff();
  if (size == 0.0) return fault(ErrorCode::degenerate, "has zero information");
  if ((info - info.transpose()).cwiseAbs().maxCoeff() > 1e-9 * size) {
    return fault(ErrorCode::invalid, "has an information matrix that is not symmetric");
  }
  if (!detail::is_semidefinite<ManifoldTraits<G>::kDof>(info)) {
    return fault(ErrorCode::invalid,
                 "has an information matrix that is not positive semi-definite");
  }
  return {};
}

/// The first fault of edge `index`, or success.
template <LieGroup G>
[[nodiscard]] Result<void> validate_edge(const PoseGraph<G>& graph, std::size_t index) {
  auto checked = validate_ends(graph, index);
  return checked ? validate_information(graph, index) : checked;
}

/// The first fault of any edge, or success.
template <LieGroup G>
[[nodiscard]] Result<void> validate_edges(const PoseGraph<G>& graph) {
  const SquareOf<G>* good = nullptr;  // most edges have the same information as the previous one
  for (std::size_t i = 0; i < graph.edges.size(); ++i) {
    if (auto checked = validate_ends(graph, i); !checked) return checked;
    const SquareOf<G>& information = graph.edges[i].information;
    if (good != nullptr && information == *good) continue;
    if (auto checked = validate_information(graph, i); !checked) return checked;
    good = &information;
  }
  return {};
}

/// Every pose must be connected to a fixed one by edges for which `counts(edge)`; `how` describes
/// those edges in the message.
template <LieGroup G, class Counts>
[[nodiscard]] Result<void> validate_connection(const PoseGraph<G>& graph, Counts counts,
                                               const std::string& how) {
  detail::Components parts(graph.size());
  for (const auto& edge : graph.edges)
    if (counts(edge)) parts.join(edge.from, edge.to);
  const int anchor = graph.fixed.empty() ? 0 : graph.fixed.front();
  for (const int pose : graph.fixed) parts.join(pose, anchor);
  for (int pose = 0; pose < graph.size(); ++pose) {
    if (parts.root(pose) == parts.root(anchor)) continue;
    return Error{ErrorCode::degenerate,
                 "pose " + graph.label(pose) + " is not connected to pose " + graph.label(anchor) +
                     (graph.fixed.size() > 1 ? " or any other fixed pose" : "") + how};
  }
  return {};
}

template <LieGroup G>
[[nodiscard]] Result<void> validate_connection(const PoseGraph<G>& graph) {
  return validate_connection(
      graph, [](const auto&) { return true; }, "");
}

/// Names the edge that makes the cost of a valid graph overflow.
template <LieGroup G>
[[nodiscard]] Error cost_overflow(const PoseGraph<G>& graph) {
  for (std::size_t i = 0; i < graph.edges.size(); ++i) {
    if (std::isfinite(squared_error(graph, graph.edges[i]))) continue;
    return detail::edge_fault(graph, i, ErrorCode::degenerate, "has an error too large to square");
  }
  return {ErrorCode::degenerate, "the sum of the edges' squared errors overflows"};
}

/// Success if the graph can be optimised; otherwise the first fault, by pose or edge.
template <LieGroup G>
[[nodiscard]] Result<void> validate(const PoseGraph<G>& graph) {
  if (graph.poses.empty()) return Error{ErrorCode::degenerate, "the graph has no poses"};
  for (int pose = 0; pose < graph.size(); ++pose) {
    if (detail::is_finite(graph.poses[static_cast<std::size_t>(pose)])) continue;
    return Error{ErrorCode::invalid, "pose " + graph.label(pose) + " is not finite"};
  }
  for (const int pose : graph.fixed) {
    if (pose >= 0 && pose < graph.size()) continue;
    return Error{ErrorCode::not_found,
                 "fixed pose " + std::to_string(pose) + " is not in the graph"};
  }
  if (auto checked = validate_edges(graph); !checked) return checked;
  return validate_connection(graph);
}

// Compiled once in wayfare::graph.
extern template Result<void> validate_ends(const PoseGraph<SE2d>&, std::size_t);
extern template Result<void> validate_information(const PoseGraph<SE2d>&, std::size_t);
extern template Result<void> validate_edge(const PoseGraph<SE2d>&, std::size_t);
extern template Result<void> validate_edges(const PoseGraph<SE2d>&);
extern template Result<void> validate_connection(const PoseGraph<SE2d>&);
extern template Error cost_overflow(const PoseGraph<SE2d>&);
extern template Result<void> validate(const PoseGraph<SE2d>&);
extern template Result<void> validate_ends(const PoseGraph<SE3d>&, std::size_t);
extern template Result<void> validate_information(const PoseGraph<SE3d>&, std::size_t);
extern template Result<void> validate_edge(const PoseGraph<SE3d>&, std::size_t);
extern template Result<void> validate_edges(const PoseGraph<SE3d>&);
extern template Result<void> validate_connection(const PoseGraph<SE3d>&);
extern template Error cost_overflow(const PoseGraph<SE3d>&);
extern template Result<void> validate(const PoseGraph<SE3d>&);

}  // namespace wayfare
