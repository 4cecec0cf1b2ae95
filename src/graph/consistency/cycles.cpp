#include "graph/consistency/cycles.hpp"

#include <algorithm>

#include <Eigen/LU>

#include <wayfare/graph/pose_graph.hpp>

#include "graph/lists.hpp"

namespace wayfare::detail {

template <LieGroup G>
SquareOf<G> edge_covariance(const PoseEdge<G>& edge) {
  SquareOf<G> information = edge.information;
  information.diagonal().array() += 1e-12 * information.diagonal().maxCoeff();
  const SquareOf<G> by =
      PoseError<G>::linearise(edge.measurement, G(), edge.measurement).by_to.inverse();
  return by * information.inverse() * by.transpose();
}

template <LieGroup G>
LoopPaths<G>::LoopPaths(const PoseGraph<G>& graph) : graph_(graph), links_(graph.poses.size()) {
  covariances_.reserve(graph.edges.size());
  for (const auto& edge : graph.edges) covariances_.push_back(edge_covariance(edge));
  for (Side& side : sides_) {
    side.seen.assign(links_.size(), 0);
    side.back.resize(links_.size());
  }
}

template <LieGroup G>
void LoopPaths<G>::accept(int edge) {
  const PoseEdge<G>& e = graph_.edges[at(edge)];
  links_[at(e.from)].push_back({e.to, edge});
  links_[at(e.to)].push_back({e.from, edge});
}

template <LieGroup G>
bool LoopPaths<G>::find(const PoseEdge<G>& loop, int hops, LoopPath<G>& path) {
  const int meeting = meet(loop.from, loop.to, hops);
  if (meeting < 0) return false;
  trace(loop.from, loop.to, meeting);
  compose(loop.from, path);
  return true;
}

template <LieGroup G>
void LoopPaths<G>::start(Side& side, int pose) const {
  side.queue.assign(1, pose);
  side.head = 0;
  side.seen[at(pose)] = search_;
  side.back[at(pose)] = {-1, -1};
}

/// Breadth first from both ends, one layer of the smaller side at a time.
template <LieGroup G>
int LoopPaths<G>::meet(int from, int to, int hops) {
  ++search_;
  auto& [first, second] = sides_;
  start(first, from);
  start(second, to);
  const auto layer = [](const Side& side) { return side.queue.size() - side.head; };
  for (int depth = 0; depth < hops && layer(first) > 0 && layer(second) > 0; ++depth) {
    const bool forwards = layer(first) <= layer(second);
    const int meeting = forwards ? advance(first, second) : advance(second, first);
    if (meeting >= 0) return meeting;
  }
  return -1;
}

/// One layer; the pose that the other side has reached, or −1.
template <LieGroup G>
int LoopPaths<G>::advance(Side& side, const Side& other) {
  for (const std::size_t end = side.queue.size(); side.head < end; ++side.head) {
    const int pose = side.queue[side.head];
    for (const Link& link : links_[at(pose)]) {
      if (side.seen[at(link.pose)] == search_) continue;
      side.seen[at(link.pose)] = search_;
      side.back[at(link.pose)] = {pose, link.edge};
      side.queue.push_back(link.pose);
      if (other.seen[at(link.pose)] == search_) return link.pose;
    }
  }
  return -1;
}

template <LieGroup G>
void LoopPaths<G>::trace(int from, int to, int meeting) {
  route_.clear();
  for (int pose = meeting; pose != from; pose = sides_[0].back[at(pose)].pose)
    route_.push_back({pose, sides_[0].back[at(pose)].edge});
  std::reverse(route_.begin(), route_.end());
  for (int pose = meeting; pose != to; pose = route_.back().pose)
    route_.push_back(sides_[1].back[at(pose)]);
}

template <LieGroup G>
void LoopPaths<G>::compose(int from, LoopPath<G>& path) const {
  path = {G(), SquareOf<G>::Zero(), 0.0};
  for (int pose = from; const Link& link : route_) {
    const PoseEdge<G>& edge = graph_.edges[at(link.edge)];
    const bool forwards = edge.from == pose;
    const G step = forwards ? edge.measurement : edge.measurement.inverse();
    const SquareOf<G> move = step.inverse().adjoint();
    // Traversed backwards, the perturbation is of the inverse.
    if (!forwards) path.covariance += covariance(link.edge);
    path.covariance = move * path.covariance * move.transpose();
    if (forwards) path.covariance += covariance(link.edge);
    path.across = path.across * step;
    path.length += step.translation().norm();
    pose = link.pose;
  }
}

template SquareOf<SE2d> edge_covariance(const PoseEdge<SE2d>&);
template SquareOf<SE3d> edge_covariance(const PoseEdge<SE3d>&);
template class LoopPaths<SE2d>;
template class LoopPaths<SE3d>;

}  // namespace wayfare::detail
