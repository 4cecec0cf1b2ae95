#include "slam/submap_slam/pieces.hpp"

#include <algorithm>
#include <cstddef>

namespace wayfare {
namespace {

/// Those of graph SLAM that the search for joins and the decision on losses use.
GraphSlamOptions graph_options(const SubmapSlamOptions& o) {
  GraphSlamOptions options;
  options.T_base_laser = o.T_base_laser;
  options.max_range_m = o.max_range_m;
  options.cell_m = o.grid.finest.resolution_m;
  options.search_sigma_m = o.loop_sigma_m;
  options.lost_scans = o.lost_scans;
  options.lost_scans_without_odometry = o.lost_scans_without_odometry;
  options.nodes_between_loops = o.nodes_between_loops;
  options.loop_context_nodes = o.loop_context_nodes;
  options.wide_loop_score = o.wide_loop_score;
  return options;
}

}  // namespace

SubmapPieces::SubmapPieces(const SubmapSlamOptions& options)
    : loss(graph_options(options)),
      options_(options),
      joiner_(graph_options(options), detail::FieldMatching(graph_options(options))) {}

bool SubmapPieces::is_usual(double score, const SubmapGraph& map) const {
  constexpr int kYoungNodes = 4;
  constexpr double kShare = 0.75, kYoungShare = 0.5, kShareInDoubt = 0.85;
  const bool is_young = map.latest() < first_of_latest() + kYoungNodes;
  const double share = loss.gap().is_doubted() ? kShareInDoubt : is_young ? kYoungShare : kShare;
  return score > share * usual_score_;
}

SE2d SubmapPieces::beside(const SubmapGraph& map) const {
  double x = 0.0;
  for (const SubmapNode& n : map.nodes) x = std::max(x, map.graph_pose(n.pose).x());
  return SE2d(x + 2.0 * options_.max_range_m, 0.0, Angle());
}

void SubmapPieces::begin(SubmapGraph& map, const SE2d& T_before_first, double reach_m) {
  std::vector<detail::Piece>& all = nodes_.all_pieces();
  if (all.empty()) all.emplace_back();
  const int first = map.latest();
  all.push_back({first, nodes_.pieces(), first - 1, T_before_first, reach_m});
  follow(map);
  hold_parts(map);
}

void SubmapPieces::follow(const SubmapGraph& map) {
  if (!are_several()) return;
  nodes_.graph().poses.resize(map.nodes.size());
  nodes_.views().resize(map.nodes.size());
  const bool may_join = !has_one_part();
  for (std::size_t k = 0; k < map.nodes.size(); ++k) {
    const SubmapNode& node = map.nodes[k];
    nodes_.graph().poses[k] = map.graph_pose(node.pose);
    detail::NodeView& view = nodes_.views()[k];
    view.travel_m = node.travel_m;
    if (!may_join) view.points = {};
    if (may_join && view.points.size() == 0) view.points = node.points->unpacked();
  }
}

bool SubmapPieces::join_latest(SubmapGraph& map) {
  if (has_one_part()) return false;
  return join(map, joiner_.search_latest(nodes_));
}

bool SubmapPieces::join_all(SubmapGraph& map) {
  if (has_one_part()) return false;
  follow(map);
  return join(map, joiner_.search_all(nodes_));
}

bool SubmapPieces::join(SubmapGraph& map, const std::vector<PoseEdge<SE2d>>& edges) {
  if (edges.empty()) return false;
  nodes_.join(edges);
  nodes_.graph().edges.clear();  // they are the map's
  give_poses(map);
  for (const PoseEdge<SE2d>& e : edges)
    map.graph.edges.push_back(
        {map.node(e.from).pose, map.node(e.to).pose, e.measurement, e.information, e.robust});
  hold_parts(map);
  follow(map);
  return true;
}

/// Submaps move with their first nodes.
void SubmapPieces::give_poses(SubmapGraph& map) const {
  const auto pose_of = [&](int index) -> SE2d& {
    return map.graph.poses[static_cast<std::size_t>(index)];
  };
  for (const Submap& s : map.submaps) {
    const SE2d by = nodes_.pose(s.first) * map.pose(s.first).inverse();
    pose_of(s.pose) = by * pose_of(s.pose);
  }
  for (int k = 0; k <= map.latest(); ++k) pose_of(map.node(k).pose) = nodes_.pose(k);
}

void SubmapPieces::place_small_parts(SubmapGraph& map) {
  if (has_one_part()) return;
  follow(map);
  joiner_.place_small_parts(nodes_);
  give_poses(map);
}

void SubmapPieces::forget(int nodes) {
  if (are_several()) nodes_.forget(nodes);
  if (!are_several()) nodes_ = {};
  moved();
}

void SubmapPieces::hold_parts(SubmapGraph& map) const {
  map.graph.fixed.clear();
  if (has_one_part()) return;
  for (const int part : nodes_.parts())
    map.graph.fixed.push_back(map.node(nodes_.first_of_piece(part)).pose);
}

bool SubmapPieces::is_in_small_part(int node) const {
  const int part = part_of(node);
  return part != 0 && joiner_.is_small(nodes_, part);
}

void SubmapPieces::count(PieceStatistics& statistics) {
  if (!are_several()) return;
  const std::size_t begun = statistics.pieces;  // of which some may be forgotten
  joiner_.count(nodes_, statistics);
  statistics.pieces = begun;
}

}  // namespace wayfare
