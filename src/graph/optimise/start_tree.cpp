#include <algorithm>
#include <cstdlib>
#include <string>
#include <utility>
#include <vector>

#include <wayfare/graph/detail/validate.hpp>
#include <wayfare/graph/pose_graph.hpp>

#include "graph/lists.hpp"

namespace wayfare {
namespace {

using detail::at;

std::vector<int> anchors_of(const auto& graph) {
  return graph.fixed.empty() ? std::vector<int>{0} : graph.fixed;
}

/// The pose of the edge's other end from the one at `pose`.
template <class G>
G across(const PoseEdge<G>& edge, int pose, const G& x) {
  return edge.from == pose ? x * edge.measurement : x * edge.measurement.inverse();
}

/// For each pose k the edge to k + 1, or −1.
template <class G>
std::vector<int> chain_of(const PoseGraph<G>& graph) {
  std::vector<int> chain(graph.poses.size(), -1);
  for (std::size_t e = 0; e < graph.edges.size(); ++e) {
    const PoseEdge<G>& edge = graph.edges[e];
    if (std::abs(edge.from - edge.to) != 1) continue;
    int& link = chain[at(std::min(edge.from, edge.to))];
    if (link < 0 || (graph.edges[at(link)].robust && !edge.robust)) link = static_cast<int>(e);
  }
  return chain;
}

/// The edges of each pose, in order.
detail::Lists<int> edges_by_pose(const auto& graph) {
  return {graph.poses.size(), [&](const auto& visit) {
            for (std::size_t e = 0; e < graph.edges.size(); ++e)
              for (const int end : {graph.edges[e].from, graph.edges[e].to})
                visit(end, static_cast<int>(e));
          }};
}

/// Sets the poses, unless sums of measurements overflow.
template <class G>
Result<void> take(PoseGraph<G>& graph, std::vector<G> x) {
  for (int pose = 0; pose < graph.size(); ++pose)
    if (!detail::is_finite(x[at(pose)]))
      return Error{ErrorCode::degenerate,
                   "pose " + graph.label(pose) + " is too far away: its coordinates overflow"};
  graph.poses = std::move(x);
  return {};
}

}  // namespace

template <LieGroup G>
Result<void> start_from_odometry(PoseGraph<G>& graph) {
  if (auto valid = validate(graph); !valid) return valid;
  const std::vector<int> chain = chain_of(graph);
  std::vector<G> x = graph.poses;
  std::vector<char> placed(x.size(), 0);
  int first = graph.size();
  for (const int a : anchors_of(graph)) placed[at(a)] = 1, first = std::min(first, a);
  const auto place = [&](int pose, int neighbour) {
    const int link = chain[at(std::min(pose, neighbour))];
    if (link >= 0) x[at(pose)] = across(graph.edges[at(link)], neighbour, x[at(neighbour)]);
    return link >= 0;
  };
  const auto broken = [&](int a, int b) {
    return Error{ErrorCode::degenerate,
                 "no odometry edge joins poses " + graph.label(a) + " and " + graph.label(b)};
  };
  for (int k = first - 1; k >= 0; --k)
    if (!place(k, k + 1)) return broken(k, k + 1);
  for (int k = first + 1; k < graph.size(); ++k)
    if (placed[at(k)] == 0 && !place(k, k - 1)) return broken(k - 1, k);
  return take(graph, std::move(x));
}

template <LieGroup G>
Result<void> start_from_tree(PoseGraph<G>& graph, TreeEdges rather) {
  if (auto valid = validate(graph); !valid) return valid;
  const auto edges_at = edges_by_pose(graph);
  struct Step {
    int pose, edge;  // the edge that reaches the pose
  };
  // Breadth first; paths over untrusted edges are used only when no other is left.
  std::vector<Step> open, later;
  std::vector<G> x = graph.poses;
  std::vector<char> placed(x.size(), 0);
  for (const int a : anchors_of(graph)) open.push_back({a, -1});
  const auto place = [&](const Step& step) {
    if (placed[at(step.pose)] != 0) return;
    placed[at(step.pose)] = 1;
    if (step.edge >= 0) {
      const PoseEdge<G>& edge = graph.edges[at(step.edge)];
      const int parent = edge.from == step.pose ? edge.to : edge.from;
      x[at(step.pose)] = across(edge, parent, x[at(parent)]);
    }
    for (const int e : edges_at[step.pose]) {
      const PoseEdge<G>& edge = graph.edges[at(e)];
      const bool waits = rather == TreeEdges::trusted_first && edge.robust;
      (waits ? later : open).push_back({edge.from == step.pose ? edge.to : edge.from, e});
    }
  };
  for (std::size_t k = 0; k < open.size(); ++k) {
    place(Step(open[k]));
    if (k + 1 == open.size()) open.insert(open.end(), later.begin(), later.end()), later.clear();
  }
  return take(graph, std::move(x));
}

template Result<void> start_from_odometry(PoseGraph<SE2d>&);
template Result<void> start_from_odometry(PoseGraph<SE3d>&);
template Result<void> start_from_tree(PoseGraph<SE2d>&, TreeEdges);
template Result<void> start_from_tree(PoseGraph<SE3d>&, TreeEdges);

}  // namespace wayfare
