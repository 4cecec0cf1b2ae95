// Additions to an incremental graph: validated, pending, admitted or withdrawn.

#include <algorithm>
#include <cmath>
#include <string>

#include <wayfare/graph/detail/validate.hpp>
#include <wayfare/graph/incremental.hpp>

namespace wayfare {

template <LieGroup G>
Result<int> IncrementalOptimiser<G>::add_pose(const G& initial, bool held) {
  if (!detail::is_finite(initial))
    return Error{ErrorCode::invalid, "pose " + std::to_string(graph_.size()) + " is not finite"};
  const int pose = graph_.add_pose(initial);
  if (held) graph_.fixed.push_back(pose);
  return pose;
}

template <LieGroup G>
Result<void> IncrementalOptimiser<G>::add_edge(const PoseEdge<G>& edge) {
  graph_.edges.push_back(edge);  // `edge` may be one of graph(): from here on it may be gone
  auto valid = validate_edge(graph_, graph_.edges.size() - 1);
  if (valid && !std::isfinite(squared_error(graph_, graph_.edges.back())))
    valid = cost_overflow(graph_);
  if (!valid) graph_.edges.pop_back();
  return valid;
}

template <LieGroup G>
Result<void> IncrementalOptimiser<G>::append(const PoseGraph<G>& grown) {
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
void IncrementalOptimiser<G>::discard_pending() {
  graph_.poses.resize(solved_poses_);
  graph_.edges.resize(solved_edges_);
  if (graph_.labels.size() > solved_poses_) graph_.labels.resize(solved_poses_);
  std::erase_if(graph_.fixed, [&](int pose) { return index(pose) >= solved_poses_; });
}

template <LieGroup G>
bool IncrementalOptimiser<G>::is_held(int pose) const {
  const auto& fixed = graph_.fixed;
  return fixed.empty() ? pose == 0 : std::find(fixed.begin(), fixed.end(), pose) != fixed.end();
}

/// Every new pose must be connected to a solved or fixed one.
template <LieGroup G>
Result<void> IncrementalOptimiser<G>::check_pending() const {
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
Error IncrementalOptimiser<G>::name_undetermined(const FactorOutcome& outcome) {
  undetermined_ = {};
  if (outcome.block >= 0) {
    undetermined_.variable = pose_of_[index(outcome.block)];
    undetermined_.direction = Eigen::Map<const TangentOf<G>>(outcome.direction.data());
  }
  return undetermined_error(graph_, undetermined_);
}

/// Pending poses and edges become part of the system.
template <LieGroup G>
void IncrementalOptimiser<G>::admit() {
  for (std::size_t i = solved_poses_; i < graph_.poses.size(); ++i) {
    const int pose = static_cast<int>(i);
    origins_.push_back(graph_.poses[i]);
    variable_of_.push_back(is_held(pose) ? -1 : system_.add_variable());
    if (variable_of_.back() >= 0) pose_of_.push_back(pose);
    is_far_.push_back(0);
  }
  costs_.resize(graph_.edges.size());
  edge_mark_.resize(graph_.edges.size(), 0);
  for (std::size_t k = solved_edges_; k < graph_.edges.size(); ++k) {
    const PoseEdge<G>& edge = graph_.edges[k];
    system_.add_term(variable_of_[index(edge.from)], variable_of_[index(edge.to)], linearise(edge));
    costs_.set(k, robust_cost(graph_, edge, kernel_));
  }
}

/// Accepts the admitted poses and edges.
template <LieGroup G>
void IncrementalOptimiser<G>::settle() {
  if (graph_.fixed.empty()) graph_.fixed.push_back(0);
  solved_poses_ = graph_.poses.size();
  solved_edges_ = graph_.edges.size();
}

/// Admitted poses and edges become pending again.
template <LieGroup G>
void IncrementalOptimiser<G>::withdraw() {
  std::size_t free = pose_of_.size();
  while (free > 0 && index(pose_of_[free - 1]) >= solved_poses_) --free;
  system_.roll_back(static_cast<int>(free), static_cast<int>(solved_edges_));
  pose_of_.resize(free);
  origins_.resize(solved_poses_);
  variable_of_.resize(solved_poses_);
  is_far_.resize(solved_poses_);
  edge_mark_.resize(solved_edges_);
  costs_.resize(solved_edges_);
}

template class IncrementalOptimiser<SE2d>;
template class IncrementalOptimiser<SE3d>;

}  // namespace wayfare
