#include <wayfare/slam/detail/graph_slam/node_merger.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Core>
#include <Eigen/LU>

namespace wayfare::detail {
namespace {

/// Nodes behind the latest that are not merged: those of the local maps and of running searches.
int window_of(const GraphSlamOptions& o) {
  return std::max({o.local_nodes, o.sharp_nodes, o.loop_gap_nodes, o.loop_context_nodes}) +
         o.nodes_between_loops + 10;
}

using Covariance = Eigen::Matrix3d;

/// A relative pose and its covariance, in the axes at its end.
struct Relative {
  SE2d pose;
  Covariance covariance = Covariance::Zero();

  explicit Relative(const PoseEdge<SE2d>& edge)
      : pose(edge.measurement), covariance(edge.information.inverse()) {}
  Relative(const SE2d& p, const Covariance& c) : pose(p), covariance(c) {}

  [[nodiscard]] Relative inverse() const {
    const Eigen::Matrix3d turn = pose.adjoint();
    return {pose.inverse(), turn * covariance * turn.transpose()};
  }
  [[nodiscard]] Relative operator*(const Relative& next) const {
    const Eigen::Matrix3d turn = next.pose.inverse().adjoint();
    return {pose * next.pose, turn * covariance * turn.transpose() + next.covariance};
  }
  [[nodiscard]] Eigen::Matrix3d information() const {
    const Covariance inverse = covariance.inverse();
    return 0.5 * (inverse + inverse.transpose());
  }
};

}  // namespace

NodeMerger::Edges NodeMerger::edges(const NodeMap& nodes) const {
  Edges found;
  const auto& edges = nodes.graph().edges;
  for (std::size_t i = 0; i < edges.size(); ++i) {
    const PoseEdge<SE2d>& e = edges[i];
    if (e.to != kept_ && e.from != kept_) continue;
    if (std::max(e.from, e.to) > kept_) {
      found.later.push_back(i);
    } else if (e.to == kept_) {
      found.links.push_back({i, e.from, e.measurement, Relative(e).covariance});
    } else {
      const Relative back = Relative(e).inverse();
      found.links.push_back({i, e.to, back.pose, back.covariance});
    }
  }
  return found;
}

/// Whether the older node, wherever it may be by the path to it, shares the view of the node. A
/// narrower limit leaves nodes in the middle of long corridors, at every pass.
bool NodeMerger::is_known(const NodeMap& nodes, int older) {
  constexpr double kLargest_m2 = 2.0;  // of a path that is followed
  const PathUncertainty& known = uncertainty_from(
      kept_, nodes.graph(), loop_kernel(options_.loop_kernel_sigmas), uncertainty_, [&](int pose) {
        return pose == older ||
               uncertainty_.result().size[static_cast<std::size_t>(pose)] > kLargest_m2;
      });
  return known.reached(older) &&
         reach_m(known.covariance[static_cast<std::size_t>(older)]) < options_.loop_overlap_m;
}

int NodeMerger::nearest_older(const NodeMap& nodes) const {
  const double turn = options_.merge_turn.radians();
  int nearest = -1;
  double distance = options_.merge_distance_m;
  for (int k = 0; k < kept_; ++k) {
    const double d = nodes.distance_m(k, kept_);
    if (d >= distance || nodes.travel_m(kept_) - nodes.travel_m(k) <= options_.loop_gap_travel_m)
      continue;
    const SE2d apart = nodes.pose(k).inverse() * nodes.pose(kept_);
    if (std::abs(apart.heading().radians()) > turn) continue;
    nearest = k;
    distance = d;
  }
  return nearest;
}

/// Keeps what the leaving node measured between kept nodes, unless they have enough edges.
void NodeMerger::join_kept(NodeMap& nodes, const std::vector<Link>& links, const Link& anchor) {
  constexpr int kMostEdges = 6;  // of a kept node
  auto& edges = nodes.graph().edges;
  degree_.assign(static_cast<std::size_t>(nodes.size()), 0);
  const auto degree = [&](int node) -> int& { return degree_[static_cast<std::size_t>(node)]; };
  for (const PoseEdge<SE2d>& e : edges) ++degree(e.from), ++degree(e.to);
  for (const Link& link : links) {
    if (link.node == anchor.node) continue;
    if (degree(link.node) >= kMostEdges || degree(anchor.node) >= kMostEdges) continue;
    const Relative to_leaving(anchor.T_node_leaving, anchor.covariance);
    const Relative joined = to_leaving * Relative(link.T_node_leaving, link.covariance).inverse();
    edges.push_back({anchor.node, link.node, joined.pose, joined.information(), true});
    ++degree(link.node), ++degree(anchor.node);
  }
}

void NodeMerger::merge(NodeMap& nodes, const Edges& own, const Link& anchor, int older,
                       std::vector<ScanPose>& scans) {
  auto& edges = nodes.graph().edges;
  const Relative to_leaving(anchor.T_node_leaving, anchor.covariance);
  for (const std::size_t i : own.later) {
    PoseEdge<SE2d>& e = edges[i];
    const bool away = e.from == kept_;
    const Relative through = to_leaving * (away ? Relative(e) : Relative(e).inverse());
    e = {anchor.node, away ? e.to : e.from, through.pose, through.information(), e.robust};
  }
  join_kept(nodes, own.links, anchor);
  std::erase_if(edges, [&](const PoseEdge<SE2d>& e) { return e.from == kept_ || e.to == kept_; });
  const SE2d T_older_leaving = nodes.pose(older).inverse() * nodes.pose(kept_);
  for (auto s = scans.rbegin(); s != scans.rend(); ++s) {
    if (s->node < kept_) break;
    if (s->node == kept_) {
      s->T_node_base = T_older_leaving * s->T_node_base;
      s->node = older;
    } else {
      --s->node;
    }
  }
  nodes.erase(kept_);
  uncertainty_.forget();
}

const NodeMerger::Link* NodeMerger::anchor(const NodeMap& nodes,
                                           const std::vector<Link>& links) const {
  const auto kernel = loop_kernel(options_.loop_kernel_sigmas);
  const Link* best = nullptr;
  for (const Link& link : links) {
    if (!agrees(nodes.graph(), nodes.graph().edges[link.edge], kernel)) continue;
    if (best == nullptr || link.covariance.trace() < best->covariance.trace()) best = &link;
  }
  return best;
}

int NodeMerger::update(NodeMap& nodes, std::vector<ScanPose>& scans) {
  if (options_.nodes_before_merging <= 0) return 0;
  const bool on = merges_nodes(options_, nodes);
  int removed = 0;
  const int window = window_of(options_);
  while (nodes.latest() - kept_ > window) {
    const int older = on && kept_ > 0 ? nearest_older(nodes) : -1;
    const bool known = older >= 0 && is_known(nodes, older);
    const Edges own = known ? edges(nodes) : Edges();
    const Link* anchor = this->anchor(nodes, own.links);
    if (anchor == nullptr) {
      ++kept_;
      continue;
    }
    merge(nodes, own, *anchor, older, scans);
    ++removed;
  }
  return removed;
}

}  // namespace wayfare::detail
