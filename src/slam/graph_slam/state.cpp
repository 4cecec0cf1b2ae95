#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include <wayfare/core/gaussian.hpp>
#include <wayfare/slam/detail/graph_slam/state.hpp>

#include "slam/pieces_archive.hpp"
#include "slam/state_archive.hpp"

namespace wayfare::detail {
namespace {

constexpr std::uint64_t kFormat = 0x32'48'50'41'52'47'53'57;  // "WSGRAPH2"

template <class A>
void field(A& a, PointSet& points) {
  std::vector<Eigen::Vector2f> xy;
  if constexpr (!A::kReads)
    for (std::size_t i = 0; i < points.size(); ++i) xy.emplace_back(points[i]);
  each(a, xy, [&](Eigen::Vector2f& p) {
    a.number(p.x());
    a.number(p.y());
  });
  if constexpr (A::kReads)
    for (const Eigen::Vector2f& p : xy) points.push_back(p);
}

template <class A>
void all_fields(A& a, GraphSlamState& s) {
  each(a, s.nodes.graph().poses, [&](SE2d& pose) { wayfare::field(a, pose); });
  wayfare::field(a, s.nodes.graph().edges);
  each(a, s.nodes.views(), [&](NodeView& view) {
    field(a, view.points);
    wayfare::field(a, view.travel_m);
  });
  each(a, s.nodes.all_pieces(), [&](Piece& piece) { field(a, piece); });
  wayfare::field(a, s.nodes.possible_joins());
  MotionState::fields(a, s.motion);
  LossState::fields(a, s.loss);
  wayfare::field(a, s.scans);
  fields(a, s.pose, s.since_node, s.last_searched, s.kept, s.nodes.merged(), s.usual_sharp);
  GraphSlamStatistics& n = s.statistics;
  for (std::size_t* count : {&n.scans, &n.unmatched_scans, &n.widened_searches, &n.loop_closures,
                             &n.loops_refused, &n.optimisations, &n.odometry_leaps, &n.pieces,
                             &n.joins, &n.joins_refused, &n.pieces_apart, &n.scans_apart})
    wayfare::field(a, *count);
  wayfare::field(a, n.matcher_errors);
}

bool has_valid_counters(const GraphSlamState& s) {
  const int latest = s.nodes.latest();
  return s.last_searched <= latest && s.last_searched > -(1 << 28) && s.kept >= 0 &&
         s.kept <= latest && s.usual_sharp >= 0.0 && s.usual_sharp <= 1.0;
}

/// Whether all indices are valid and the invariants of the class hold. The digest does not show
/// that: whoever changes a state can compute it.
bool is_valid(GraphSlamState& s) {
  const PoseGraph2& graph = s.nodes.graph();
  const std::size_t poses = graph.poses.size();
  if (poses == 0)
    return s.scans.empty() && graph.edges.empty() && s.nodes.views().empty() &&
           s.nodes.all_pieces().empty() && s.nodes.possible_joins().empty();
  return s.nodes.views().size() == poses && !s.scans.empty() &&
         std::ranges::all_of(graph.poses, is_near) && has_valid_edges(graph, graph.edges) &&
         has_valid_pieces(s.nodes, s.nodes.size()) &&
         has_valid_edges(graph, s.nodes.possible_joins()) && LossState::is_valid(s.loss) &&
         std::ranges::is_sorted(s.scans, {}, &ScanPose::time) &&
         std::ranges::all_of(
             s.scans,
             [&](const ScanPose& p) { return in(p.node, poses) && is_near(p.T_node_base); }) &&
         MotionState::is_valid(s.motion, true) && is_near(s.pose) &&
         is_positive_semidefinite(s.since_node) && has_valid_counters(s);
}

}  // namespace

std::vector<std::uint8_t> save(GraphSlamState state) {
  StateWriter a;
  a.number(kFormat);
  all_fields(a, state);
  return std::move(a).finished();
}

Result<void> restore(GraphSlamState state, std::span<const std::uint8_t> bytes) {
  const auto opened = open_state(bytes, {kFormat}, "a map saved by graph SLAM");
  if (!opened) return opened.error();
  StateReader a(opened->content);
  all_fields(a, state);
  if (!a.ok() || a.left() != 0 || !is_valid(state))
    return state_fault("values that are not a valid map", sizeof(std::uint64_t) + a.at());
  state.nodes.hold_parts();
  return {};
}

}  // namespace wayfare::detail
