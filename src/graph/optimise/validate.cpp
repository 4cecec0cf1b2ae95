#include <wayfare/graph/detail/factor_equations.hpp>
#include <wayfare/graph/detail/validate.hpp>

#include <Eigen/Cholesky>

namespace wayfare {
namespace {

/// Positive semi-definite to rounding: zero information in a direction is valid, negative
/// information is not.
template <class Square>
bool is_semidefinite(const Square& m) {
  // The diagonal is raised by the rounding error of the eigenvalues. LDLᵀ is unsuitable: pivots of
  // a singular matrix are rounding errors, on which it can fail.
  const double rounding = 1e-12 * m.cwiseAbs().maxCoeff();
  if (rounding == 0.0) return true;
  // Gershgorin: every eigenvalue is at least a diagonal entry minus the rest of its row.
  const auto rest = m.cwiseAbs().rowwise().sum() - m.diagonal().cwiseAbs();
  if ((m.diagonal() - rest).minCoeff() >= 0.0) return true;
  return Eigen::LLT<Square>(m + rounding * Square::Identity(m.rows(), m.cols())).info() ==
         Eigen::Success;
}

/// Success, or what is wrong with an edge's information.
template <class Square>
Result<void> fault_of(const Square& info) {
  if (!info.allFinite()) return Error{ErrorCode::invalid, "has an information that is not finite"};
  const double size = info.cwiseAbs().maxCoeff();
  if (size == 0.0) return Error{ErrorCode::degenerate, "has zero information"};
  if ((info - info.transpose()).cwiseAbs().maxCoeff() > 1e-9 * size)
    return Error{ErrorCode::invalid, "has an information matrix that is not symmetric"};
  if (!is_semidefinite(info))
    return Error{ErrorCode::invalid,
                 "has an information matrix that is not positive semi-definite"};
  return {};
}

template <LieGroup G>
Error edge_fault(const PoseGraph<G>& graph, std::size_t index, ErrorCode code,
                 const std::string& what) {
  const PoseEdge<G>& edge = graph.edges[index];
  return {code, "edge " + std::to_string(index) + " (" + graph.label(edge.from) + " -> " +
                    graph.label(edge.to) + ") " + what};
}

/// The first fault of edge `index` except for its information.
template <LieGroup G>
Result<void> validate_ends(const PoseGraph<G>& graph, std::size_t index) {
  const PoseEdge<G>& edge = graph.edges[index];
  for (const int end : {edge.from, edge.to}) {
    if (end >= 0 && end < graph.size()) continue;
    return edge_fault(graph, index, ErrorCode::not_found,
                      "names pose " + std::to_string(end) + ", which the graph does not have");
  }
  if (edge.from == edge.to)
    return edge_fault(graph, index, ErrorCode::invalid, "joins a pose to itself");
  if (detail::is_finite(edge.measurement)) return {};
  return edge_fault(graph, index, ErrorCode::invalid, "has a measurement that is not finite");
}

template <LieGroup G>
Result<void> validate_information(const PoseGraph<G>& graph, std::size_t index) {
  const auto checked = fault_of(graph.edges[index].information);
  if (checked) return {};
  return edge_fault(graph, index, checked.error().code, checked.error().message);
}

}  // namespace

Result<void> detail::check_information(const Eigen::Ref<const Eigen::MatrixXd>& information) {
  return fault_of(Eigen::MatrixXd(information));
}

Error detail::edge_fault(int index, std::span<const int> variables, ErrorCode code,
                         const std::string& what) {
  std::string text = "edge " + std::to_string(index) + " (";
  for (std::size_t i = 0; i < variables.size(); ++i)
    text += (i == 0 ? "" : ", ") + std::to_string(variables[i]);
  return {code, text + ") " + what};
}

template <LieGroup G>
Result<void> validate_edge(const PoseGraph<G>& graph, std::size_t index) {
  auto checked = validate_ends(graph, index);
  return checked ? validate_information(graph, index) : checked;
}

template <LieGroup G>
Result<void> validate_connection(
    const PoseGraph<G>& graph,
    const std::type_identity_t<std::function<bool(const PoseEdge<G>&)>>& counts,
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
Error cost_overflow(const PoseGraph<G>& graph) {
  for (std::size_t i = 0; i < graph.edges.size(); ++i) {
    if (std::isfinite(squared_error(graph, graph.edges[i]))) continue;
    return edge_fault(graph, i, ErrorCode::degenerate, "has an error too large to square");
  }
  return {ErrorCode::degenerate, "the sum of the edges' squared errors overflows"};
}

template <LieGroup G>
Result<void> validate(const PoseGraph<G>& graph) {
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
  const SquareOf<G>* good = nullptr;  // most edges have the same information as the previous one
  for (std::size_t i = 0; i < graph.edges.size(); ++i) {
    if (auto checked = validate_ends(graph, i); !checked) return checked;
    const SquareOf<G>& information = graph.edges[i].information;
    if (good != nullptr && information == *good) continue;
    if (auto checked = validate_information(graph, i); !checked) return checked;
    good = &information;
  }
  return validate_connection(
      graph, [](const auto&) { return true; }, "");
}

template Result<void> validate(const PoseGraph<SE2d>&);
template Result<void> validate(const PoseGraph<SE3d>&);
template Result<void> validate_edge(const PoseGraph<SE2d>&, std::size_t);
template Result<void> validate_edge(const PoseGraph<SE3d>&, std::size_t);
template Result<void> validate_connection(const PoseGraph<SE2d>&,
                                          const std::function<bool(const PoseEdge<SE2d>&)>&,
                                          const std::string&);
template Result<void> validate_connection(const PoseGraph<SE3d>&,
                                          const std::function<bool(const PoseEdge<SE3d>&)>&,
                                          const std::string&);
template Error cost_overflow(const PoseGraph<SE2d>&);
template Error cost_overflow(const PoseGraph<SE3d>&);

}  // namespace wayfare
