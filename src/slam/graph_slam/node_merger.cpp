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

bool agrees(const PoseGraph2& graph, const PoseEdge<SE2d>& edge, const RobustKernel& kernel) {
  return !edge.robust || kernel(squared_error(graph, edge)).weight > 0.3;
}

}  // namespace

std::vector<NodeMerger::Link> NodeMerger::links(const NodeMap& nodes) const {
  std::vector<Link> found;
  const auto& edges = nodes.graph().edges;
  for (std::size_t i = 0; i < edges.size(); ++i) {
    const PoseEdge<SE2d>& e = edges[i];
    if (e.to == kept_ && e.from < kept_) {
      found.push_back({i, e.from, e.measurement, Relative(e).covariance});
    } else if (e.from == kept_ && e.to < kept_) {
      const Relative back = Relative(e).inverse();
      found.push_back({i, e.to, back.pose, back.covariance});
    }
  }
  return found;
}

bool NodeMerger::is_known(const NodeMap& nodes, const Link& link) const {
  constexpr double kReach_m = 0.5;
  const auto kernel = loop_kernel(options_.loop_kernel_sigmas);
  return nodes.travel_m(kept_) - nodes.travel_m(link.node) > options_.loop_gap_travel_m &&
         reach_m(link.covariance) < kReach_m &&
         agrees(nodes.graph(), nodes.graph().edges[link.edge], kernel);
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
  const auto degree = [&](int node) {
    return std::ranges::count_if(
        edges, [&](const PoseEdge<SE2d>& e) { return e.from == node || e.to == node; });
  };
  for (const Link& link : links) {
    if (link.node == anchor.node) continue;
    if (degree(link.node) >= kMostEdges || degree(anchor.node) >= kMostEdges) continue;
    const Relative to_leaving(anchor.T_node_leaving, anchor.covariance);
    const Relative joined = to_leaving * Relative(link.T_node_leaving, link.covariance).inverse();
    edges.push_back({anchor.node, link.node, joined.pose, joined.information(), true});
  }
}

void NodeMerger::merge(NodeMap& nodes, const std::vector<Link>& links, const Link& anchor,
                       int older, std::vector<ScanPose>& scans) {
  auto& edges = nodes.graph().edges;
  const Relative to_leaving(anchor.T_node_leaving, anchor.covariance);
  for (PoseEdge<SE2d>& e : edges) {
    if (e.from == kept_ && e.to > kept_) {
      const Relative through = to_leaving * Relative(e);
      e = {anchor.node, e.to, through.pose, through.information(), e.robust};
    } else if (e.to == kept_ && e.from > kept_) {
      const Relative through = to_leaving * Relative(e).inverse();
      e = {anchor.node, e.from, through.pose, through.information(), e.robust};
    }
  }
  join_kept(nodes, links, anchor);
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
}

int NodeMerger::update(NodeMap& nodes, std::vector<ScanPose>& scans) {
  if (options_.nodes_before_merging <= 0) return 0;
  const bool on = is_on(nodes);
  int removed = 0;
  const int window = window_of(options_);
  while (nodes.latest() - kept_ > window) {
    const int older = on && kept_ > 0 ? nearest_older(nodes) : -1;
    const std::vector<Link> all = older < 0 ? std::vector<Link>() : links(nodes);
    const Link* anchor = nullptr;
    for (const Link& link : all)
      if (is_known(nodes, link) &&
          (anchor == nullptr || link.covariance.trace() < anchor->covariance.trace()))
        anchor = &link;
    if (anchor == nullptr) {
      ++kept_;
      continue;
    }
    merge(nodes, all, *anchor, older, scans);
    ++removed;
  }
  return removed;
}

}  // namespace wayfare::detail
