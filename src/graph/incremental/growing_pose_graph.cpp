// Additions to an incremental pose graph.

#include <algorithm>
#include <cmath>
#include <string>

#include <wayfare/graph/detail/normal_equations.hpp>
#include <wayfare/graph/detail/validate.hpp>
#include <wayfare/graph/incremental.hpp>

namespace wayfare {

template <LieGroup G>
Result<int> GrowingGraph<PoseGraph<G>>::add_pose(const G& initial, bool held) {
  if (!detail::is_finite(initial))
    return Error{ErrorCode::invalid, "pose " + std::to_string(graph_.size()) + " is not finite"};
  const int pose = graph_.add_pose(initial);
  if (held) graph_.fixed.push_back(pose);
  return pose;
}

template <LieGroup G>
Result<void> GrowingGraph<PoseGraph<G>>::add_edge(const PoseEdge<G>& edge) {
  graph_.edges.push_back(edge);  // `edge` may be one of graph(): from here on it may be gone
  auto valid = validate_edge(graph_, graph_.edges.size() - 1);
  if (valid && !std::isfinite(squared_error(graph_, graph_.edges.back())))
    valid = cost_overflow(graph_);
  if (!valid) graph_.edges.pop_back();
  return valid;
}

template <LieGroup G>
Result<void> GrowingGraph<PoseGraph<G>>::append(const PoseGraph<G>& grown) {
  const auto poses = graph_.poses.size(), edges = graph_.edges.size();
  const auto held = graph_.fixed;
  const auto labels = graph_.labels;
  const auto take = [&]() -> Result<void> {
    if (grown.poses.size() < poses || grown.edges.size() < edges)
      return Error{ErrorCode::invalid, "the graph has lost poses or edges"};
    graph_.labels = grown.labels;
    for (const int pose : grown.fixed) {
      if (pose < 0 || pose >= grown.size())
        return Error{ErrorCode::not_found,
                     "fixed pose " + std::to_string(pose) + " is not in the graph"};
      auto& fixed = graph_.fixed;
      if (index(pose) >= poses || std::find(fixed.begin(), fixed.end(), pose) != fixed.end())
        continue;
      if (index(pose) < solved_poses_)
        return Error{ErrorCode::unsupported,
                     "pose " + graph_.label(pose) + " was free and is fixed now"};
      fixed.push_back(pose);
    }
    for (std::size_t i = poses; i < grown.poses.size(); ++i) {
      const int pose = static_cast<int>(i);
      const bool fixed =
          std::find(grown.fixed.begin(), grown.fixed.end(), pose) != grown.fixed.end();
      if (auto added = add_pose(grown.poses[i], fixed); !added) return added.error();
    }
    for (std::size_t i = edges; i < grown.edges.size(); ++i)
      if (auto added = add_edge(grown.edges[i]); !added) return added;
    return {};
  };
  auto taken = take();
  if (taken) return taken;
  graph_.poses.resize(poses);
  graph_.edges.resize(edges);
  graph_.fixed = held;
  graph_.labels = labels;
  return taken;
}

template <LieGroup G>
void GrowingGraph<PoseGraph<G>>::discard_pending() {
  graph_.poses.resize(solved_poses_);
  graph_.edges.resize(solved_edges_);
  if (graph_.labels.size() > solved_poses_) graph_.labels.resize(solved_poses_);
  std::erase_if(graph_.fixed, [&](int pose) { return index(pose) >= solved_poses_; });
}

template <LieGroup G>
bool GrowingGraph<PoseGraph<G>>::is_held(int pose) const {
  const auto& fixed = graph_.fixed;
  return fixed.empty() ? pose == 0 : std::find(fixed.begin(), fixed.end(), pose) != fixed.end();
}

/// Every new pose must be connected to a solved or fixed one.
template <LieGroup G>
Result<void> GrowingGraph<PoseGraph<G>>::check_pending() const {
  if (graph_.poses.empty()) return Error{ErrorCode::degenerate, "the graph has no poses"};
  const int solved = static_cast<int>(solved_poses_);
  const int anchor = graph_.size() - solved;  // represents all solved or fixed poses
  detail::Components parts(anchor + 1);
  const auto part = [&](int pose) {
    return pose < solved || is_held(pose) ? anchor : pose - solved;
  };
  for (std::size_t k = solved_edges_; k < graph_.edges.size(); ++k)
    parts.join(part(graph_.edges[k].from), part(graph_.edges[k].to));
  for (int pose = solved; pose < graph_.size(); ++pose) {
    if (parts.root(part(pose)) == parts.root(anchor)) continue;
    const int held = graph_.fixed.empty() ? 0 : graph_.fixed.front();
    return Error{ErrorCode::degenerate, "pose " + graph_.label(pose) +
                                            " is not connected to pose " + graph_.label(held) +
                                            (solved > 1 ? " or any other solved pose" : "")};
  }
  return {};
}

template <LieGroup G>
void GrowingGraph<PoseGraph<G>>::settle() {
  if (graph_.fixed.empty()) graph_.fixed.push_back(0);
  solved_poses_ = graph_.poses.size();
  solved_edges_ = graph_.edges.size();
}

template <LieGroup G>
void GrowingGraph<PoseGraph<G>>::unsettle(const Solved& before) {
  graph_.fixed.resize(before.fixed);
  solved_poses_ = before.poses;
  solved_edges_ = before.edges;
}

template <LieGroup G>
auto GrowingGraph<PoseGraph<G>>::terms_of(const PoseEdge<G>& edge,
                                          const std::vector<G>& origins) const
    -> IncrementalTerm<kBlock> {
  EdgeTerms<G> terms;
  edge_terms(edge, origins[index(edge.from)], origins[index(edge.to)], terms);
  const double weight = edge.robust ? kernel_(terms.squared_error).weight : 1.0;
  IncrementalTerm<kBlock> term;
  term.aa = weight * terms.from;
  term.ab = weight * terms.between;
  term.bb = weight * terms.to;
  term.ra = -weight * terms.from_gradient;
  term.rb = -weight * terms.to_gradient;
  return term;
}

template class GrowingGraph<PoseGraph<SE2d>>;
template class GrowingGraph<PoseGraph<SE3d>>;
template class IncrementalGraphOptimiser<PoseGraph<SE2d>>;
template class IncrementalGraphOptimiser<PoseGraph<SE3d>>;

}  // namespace wayfare
