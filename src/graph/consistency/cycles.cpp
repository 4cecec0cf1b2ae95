#include "graph/consistency/cycles.hpp"

#include <algorithm>
#include <cstdlib>
#include <utility>

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

/// For each pose k > 0 the trusted edge to k − 1, or −1.
template <LieGroup G>
std::vector<int> chain_of(const PoseGraph<G>& graph) {
  std::vector<int> chain(graph.poses.size(), -1);
  for (std::size_t k = 0; k < graph.edges.size(); ++k) {
    const PoseEdge<G>& edge = graph.edges[k];
    if (edge.robust || std::abs(edge.from - edge.to) != 1) continue;
    int& link = chain[at(std::max(edge.from, edge.to))];
    if (link < 0) link = static_cast<int>(k);
  }
  return chain;
}

template <LieGroup G>
LoopPaths<G>::LoopPaths(const PoseGraph<G>& graph)
    : graph_(graph),
      chain_(chain_of(graph)),
      odometry_(graph.poses.size()),
      sums_(graph.poses.size(), SquareOf<G>::Zero()),
      lengths_(graph.poses.size(), 0.0),
      edges_(graph.edges.size(), kNone) {
  covariances_.reserve(graph.edges.size());
  for (const auto& edge : graph.edges) {
    covariances_.push_back(edge_covariance(edge));
    ends_.emplace_back(edge.from, edge.to);
  }
  for (int k = 1; k < graph.size(); ++k) {
    const PoseEdge<G>& edge = graph.edges[at(chain_[at(k)])];
    const G& step = edge.measurement;
    odometry_[at(k)] = odometry_[at(k - 1)] * (edge.to == k ? step : step.inverse());
    const SquareOf<G> move = odometry_[at(edge.to)].adjoint();
    sums_[at(k)] = sums_[at(k - 1)] + move * covariance(chain_[at(k)]) * move.transpose();
    lengths_[at(k)] = lengths_[at(k - 1)] + step.translation().norm();
  }
  for (Side& side : sides_) {
    side.poses.resize(graph.poses.size());
    side.queue.resize(graph.poses.size() + 1);
  }
}

template <LieGroup G>
void LoopPaths<G>::accept(const std::vector<int>& edges) {
  accepted_.insert(accepted_.end(), edges.begin(), edges.end());
  links_ = Lists<Link>(graph_.poses.size(), [&](const auto& visit) {
    for (const int edge : accepted_) {
      const auto [from, to] = ends_[at(edge)];
      const int direction = edge == chain_[at(std::max(from, to))] ? to - from : 0;
      visit(from, Link{to, {4 * edge + 1 + direction}});
      visit(to, Link{from, {4 * edge + 1 - direction}});
    }
  });
}

template <LieGroup G>
bool LoopPaths<G>::find(int loop, int hops, LoopPath<G>& path) {
  const PoseEdge<G>& ends = graph_.edges[at(loop)];
  const int meeting = meet(ends.from, ends.to, hops);
  if (meeting < 0) return false;
  edges_[at(loop)] = sides_[0][meeting].depth + sides_[1][meeting].depth;
  trace(ends.from, ends.to, meeting);
  compose(ends.from, path);
  return true;
}

template <LieGroup G>
std::vector<int> LoopPaths<G>::affected(const std::vector<int>& edges,
                                        const std::vector<int>& loops, int hops) {
  Side& side = sides_[0];
  ++search_;
  clear(side);
  for (const int edge : edges)
    for (const int pose : {ends_[at(edge)].first, ends_[at(edge)].second})
      if (side[pose].search != search_) start(side, pose);
  while (side.layer() > 0) advance(side, nullptr);
  std::vector<int> found;
  for (const int k : loops) {
    const auto [from, to] = ends_[at(k)];
    const int least = side[from].depth + 1 + side[to].depth;
    if (least <= hops && least < edges_[at(k)]) found.push_back(k);
  }
  return found;
}

template <LieGroup G>
void LoopPaths<G>::start(Side& side, int pose) const {
  side.queue[side.tail++] = pose;
  side.poses[at(pose)] = {search_, 0, {}, pose};
}

/// Breadth first from both ends, one layer of the smaller side at a time.
template <LieGroup G>
int LoopPaths<G>::meet(int from, int to, int hops) {
  ++search_;
  auto& [first, second] = sides_;
  clear(first), clear(second);
  start(first, from), start(second, to);
  for (int depth = 0; depth < hops && first.layer() > 0 && second.layer() > 0; ++depth) {
    const bool forwards = first.layer() <= second.layer();
    const int meeting = forwards ? advance(first, &second) : advance(second, &first);
    if (meeting >= 0) return meeting;
  }
  return -1;
}

/// One layer; ends at a pose that the other side, if there is one, has reached, and returns it, or
/// −1. Whether a pose was reached before cannot be predicted, so that there is no branch on it.
template <LieGroup G>
int LoopPaths<G>::advance(Side& side, const Side* other) const {
  int* const queue = side.queue.data();
  std::size_t tail = side.tail;
  for (const std::size_t end = side.tail; side.head < end; ++side.head) {
    const Reached last = side[queue[side.head]];
    for (const Link& link : links_[queue[side.head]]) {
      Reached& next = side.poses[at(link.pose)];
      const bool fresh = next.search != search_;
      const int head = last.step.continues(link.step) ? last.head : link.pose;
      next.search = search_;
      next.depth = fresh ? last.depth + 1 : next.depth;
      next.step.code = fresh ? link.step.code : next.step.code;
      next.head = fresh ? head : next.head;
      queue[tail] = link.pose;
      tail += fresh ? 1 : 0;
      if (other && (*other)[link.pose].search == search_) return link.pose;
    }
  }
  side.tail = tail;
  return -1;
}

template <LieGroup G>
void LoopPaths<G>::search_from(int pose, int hops) {
  Side& side = sides_[0];
  ++search_;
  clear(side);
  start(side, pose);
  for (int depth = 0; depth < hops && side.layer() > 0; ++depth) advance(side, nullptr);
}

/// Where the stretch or edge to a pose comes from, and its step.
template <LieGroup G>
auto LoopPaths<G>::back(const Side& side, int pose) const -> Link {
  const Reached& reached = side[pose];
  if (const int direction = reached.step.direction())
    return {reached.head - direction, reached.step};
  const auto [from, to] = ends_[at(reached.step.edge())];
  return {from == pose ? to : from, reached.step};
}

template <LieGroup G>
void LoopPaths<G>::trace(int from, int to, int meeting) {
  route_.clear();
  for (int pose = meeting; pose != from;) {
    const Link link = back(sides_[0], pose);
    route_.push_back({pose, link.step});
    pose = link.pose;
  }
  std::reverse(route_.begin(), route_.end());
  for (int pose = meeting; pose != to; pose = route_.back().pose)
    route_.push_back(back(sides_[1], pose));
}

/// In the tree of a search that has reached both; the number of edges. Of two stretches the one
/// that begins deeper does not hold the meeting.
template <LieGroup G>
int LoopPaths<G>::trace(int from, int to, const Side& side) {
  route_.clear();
  ending_.clear();
  int a = from, b = to;
  while (side[a].head != side[b].head) {
    if (side.head_depth(a) >= side.head_depth(b)) {
      route_.push_back(back(side, a));
      a = route_.back().pose;
    } else {
      const Link link = back(side, b);
      ending_.push_back({b, link.step});
      b = link.pose;
    }
  }
  const int meeting = std::min(side[a].depth, side[b].depth);
  if (a != b) route_.push_back({b, side[a].depth > meeting ? side[a].step : side[b].step});
  route_.insert(route_.end(), ending_.rbegin(), ending_.rend());
  return side[from].depth + side[to].depth - 2 * meeting;
}

template <LieGroup G>
LoopPath<G> LoopPaths<G>::along_chain(int from, int to) const {
  const auto [first, last] = std::minmax(from, to);
  const SquareOf<G> move = odometry_[at(to)].inverse().adjoint();
  return {odometry_[at(from)].inverse() * odometry_[at(to)],
          move * (sums_[at(last)] - sums_[at(first)]) * move.transpose(),
          lengths_[at(last)] - lengths_[at(first)]};
}

template <LieGroup G>
LoopPath<G> LoopPaths<G>::over(int from, const Link& link) const {
  const int k = link.step.edge();
  const PoseEdge<G>& edge = graph_.edges[at(k)];
  const double length = edge.measurement.translation().norm();
  if (edge.from == from) return {edge.measurement, covariance(k), length};
  // Traversed backwards, the perturbation is of the inverse.
  const SquareOf<G> move = edge.measurement.adjoint();
  return {edge.measurement.inverse(), move * covariance(k) * move.transpose(), length};
}

template <LieGroup G>
void LoopPaths<G>::compose(int from, LoopPath<G>& path) const {
  path = {G(), SquareOf<G>::Zero(), 0.0};
  for (const Link& link : route_) {
    const LoopPath<G> part =
        link.step.direction() != 0 ? along_chain(from, link.pose) : over(from, link);
    const SquareOf<G> move = part.across.inverse().adjoint();
    path.covariance = move * path.covariance * move.transpose() + part.covariance;
    path.across = path.across * part.across;
    path.length += part.length;
    from = link.pose;
  }
}

template SquareOf<SE2d> edge_covariance(const PoseEdge<SE2d>&);
template SquareOf<SE3d> edge_covariance(const PoseEdge<SE3d>&);
template std::vector<int> chain_of(const PoseGraph<SE2d>&);
template std::vector<int> chain_of(const PoseGraph<SE3d>&);
template class LoopPaths<SE2d>;
template class LoopPaths<SE3d>;

}  // namespace wayfare::detail
