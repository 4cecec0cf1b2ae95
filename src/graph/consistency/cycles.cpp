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
  for (Side& side : sides_) side.poses.resize(graph.poses.size());
}

template <LieGroup G>
void LoopPaths<G>::accept(const std::vector<int>& edges) {
  accepted_.insert(accepted_.end(), edges.begin(), edges.end());
  links_ = Lists<Link>(graph_.poses.size(), [&](const auto& visit) {
    for (const int edge : accepted_) {
      const auto [from, to] = ends_[at(edge)];
      visit(from, Link{to, edge});
      visit(to, Link{from, edge});
    }
  });
}

template <LieGroup G>
bool LoopPaths<G>::find(int loop, int hops, LoopPath<G>& path) {
  const PoseEdge<G>& ends = graph_.edges[at(loop)];
  const int meeting = meet(ends.from, ends.to, hops);
  if (meeting < 0) return false;
  trace(ends.from, ends.to, meeting);
  edges_[at(loop)] = static_cast<int>(route_.size());
  compose(ends.from, path);
  return true;
}

template <LieGroup G>
void LoopPaths<G>::start(Side& side, int pose) const {
  side.queue.assign(1, pose);
  side.head = 0;
  side.poses[at(pose)] = {search_, 0, {-1, -1}};
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
    const int meeting = forwards ? advance(first, &second) : advance(second, &first);
    if (meeting >= 0) return meeting;
  }
  return -1;
}

/// One layer; ends at a pose that the other side, if there is one, has reached, and returns it, or
/// −1.
template <LieGroup G>
int LoopPaths<G>::advance(Side& side, const Side* other) const {
  for (const std::size_t end = side.queue.size(); side.head < end; ++side.head) {
    const int pose = side.queue[side.head];
    const int depth = side[pose].depth + 1;
    for (const Link& link : links_[pose]) {
      Reached& next = side.poses[at(link.pose)];
      if (next.search == search_) continue;
      next = {search_, depth, {pose, link.edge}};
      side.queue.push_back(link.pose);
      if (other && (*other)[link.pose].search == search_) return link.pose;
    }
  }
  return -1;
}

template <LieGroup G>
void LoopPaths<G>::trace(int from, int to, int meeting) {
  route_.clear();
  for (int pose = meeting; pose != from; pose = sides_[0][pose].back.pose)
    route_.push_back({pose, sides_[0][pose].back.edge});
  std::reverse(route_.begin(), route_.end());
  for (int pose = meeting; pose != to; pose = route_.back().pose)
    route_.push_back(sides_[1][pose].back);
}

/// In the tree of a search that has reached both.
template <LieGroup G>
void LoopPaths<G>::trace(int from, int to, const Side& side) {
  route_.clear();
  int a = from, b = to;
  while (side[a].depth > side[b].depth) a = side[a].back.pose;
  while (side[b].depth > side[a].depth) b = side[b].back.pose;
  while (a != b) a = side[a].back.pose, b = side[b].back.pose;
  const int meeting = a;
  for (int pose = from; pose != meeting; pose = side[pose].back.pose)
    route_.push_back(side[pose].back);
  const auto second = static_cast<std::ptrdiff_t>(route_.size());
  for (int pose = to; pose != meeting; pose = side[pose].back.pose)
    route_.push_back({pose, side[pose].back.edge});
  std::reverse(route_.begin() + second, route_.end());
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
  const PoseEdge<G>& edge = graph_.edges[at(link.edge)];
  const double length = edge.measurement.translation().norm();
  if (edge.from == from) return {edge.measurement, covariance(link.edge), length};
  // Traversed backwards, the perturbation is of the inverse.
  const SquareOf<G> move = edge.measurement.adjoint();
  return {edge.measurement.inverse(), move * covariance(link.edge) * move.transpose(), length};
}

/// Stretches along the chain are taken at once.
template <LieGroup G>
void LoopPaths<G>::compose(int from, LoopPath<G>& path) const {
  const auto of_chain = [&](int pose, const Link& link) {
    return link.edge == chain_[at(std::max(pose, link.pose))];
  };
  path = {G(), SquareOf<G>::Zero(), 0.0};
  for (std::size_t k = 0; k < route_.size(); ++k) {
    int end = route_[k].pose;
    const bool chain = of_chain(from, route_[k]);
    for (; chain && k + 1 < route_.size() && of_chain(end, route_[k + 1]); ++k)
      end = route_[k + 1].pose;
    const LoopPath<G> part = chain ? along_chain(from, end) : over(from, route_[k]);
    const SquareOf<G> move = part.across.inverse().adjoint();
    path.covariance = move * path.covariance * move.transpose() + part.covariance;
    path.across = path.across * part.across;
    path.length += part.length;
    from = end;
  }
}

template SquareOf<SE2d> edge_covariance(const PoseEdge<SE2d>&);
template SquareOf<SE3d> edge_covariance(const PoseEdge<SE3d>&);
template std::vector<int> chain_of(const PoseGraph<SE2d>&);
template std::vector<int> chain_of(const PoseGraph<SE3d>&);
template class LoopPaths<SE2d>;
template class LoopPaths<SE3d>;

}  // namespace wayfare::detail
