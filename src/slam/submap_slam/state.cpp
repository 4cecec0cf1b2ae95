#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <wayfare/core/gaussian.hpp>

#include "slam/pieces_archive.hpp"
#include "slam/state_archive.hpp"
#include "slam/submap_slam/engine.hpp"

namespace wayfare {
namespace {

// The formats, least byte first. Earlier ones have one piece; the first does not tell the matcher,
// nor its errors.
constexpr std::uint64_t kMagic = 0x34'50'41'4d'42'55'53'57;      // "WSUBMAP4"
constexpr std::uint64_t kOnePiece = 0x33'50'41'4d'42'55'53'57;   // "WSUBMAP3"
constexpr std::uint64_t kNoMatcher = 0x32'50'41'4d'42'55'53'57;  // "WSUBMAP2"

}  // namespace

/// The fields of a SubmapSlamSystem.
struct SubmapState {
  template <class A>
  static void map(A& a, SubmapGraph& map) {
    each(a, map.graph.poses, [&](SE2d& pose) { field(a, pose); });
    field(a, map.graph.edges);
    each(a, map.nodes, [&](SubmapNode& n) {
      fields(a, n.pose, n.T_local_node, n.travel_m);
      std::vector<std::int16_t> xy;
      if constexpr (!A::kReads) xy = n.points->xy();
      each(a, xy, [&](std::int16_t& t) { field(a, t); });
      if constexpr (A::kReads) n.points = std::make_shared<const PackedPoints>(std::move(xy));
    });
    each(a, map.submaps, [&](Submap& s) {
      fields(a, s.id, s.pose, s.T_local_submap, s.first, s.last, s.finished);
    });
    field(a, map.next_id_);
  }

  template <class A>
  static void path(A& a, SubmapSlamSystem::Engine& e) {
    each(a, e.forgotten_, [&](StampedPose& p) {
      field(a, p.time);
      SE2d pose = p.T_map_base.raw();
      field(a, pose);
      p.T_map_base = MapPose(pose);
    });
    field(a, e.scans_);
  }

  template <class A>
  static void all_fields(A& a, SubmapSlamSystem::Engine& e, Loops& pending) {
    map(a, e.map_);
    MotionState::fields(a, e.motion_model_);
    path(a, e);
    fields(a, e.T_local_base_, e.since_node_, e.since_match_, e.lost_, e.nodes_since_search_);
    optional_field(a, e.join_at_, [&](std::uint64_t& n) { field(a, n); });
    field(a, pending.edges);
    SubmapSlamStatistics& s = e.statistics_;
    for (std::size_t* n :
         {&pending.refused, &s.scans, &s.unmatched_scans, &s.nodes, &s.submaps,
          &s.forgotten_submaps, &s.loop_closures, &s.loops_refused, &s.optimisations})
      field(a, *n);
  }
  template <class A>
  static void errors(A& a, SubmapSlamSystem::Engine& e, Loops& pending) {
    fields(a, pending.errors, e.statistics_.matcher_errors);
  }

  template <class A>
  static void pieces(A& a, SubmapSlamSystem::Engine& e) {
    SubmapPieces& p = e.pieces_;
    each(a, p.nodes_.all_pieces(), [&](detail::Piece& piece) { field(a, piece); });
    field(a, p.nodes_.possible_joins());
    detail::LossState::fields(a, p.loss);
    field(a, p.usual_score_);
    PieceStatistics& s = e.statistics_;
    for (std::size_t* n : {&s.odometry_leaps, &s.pieces, &s.joins, &s.joins_refused,
                           &s.pieces_apart, &s.scans_apart})
      field(a, *n);
  }
  /// Of a state without pieces.
  static void begin_pieces(SubmapSlamSystem::Engine& e) {
    if (e.scans_.empty()) return;
    e.pieces_.loss.begin(e.scans_.back().time);
    e.statistics_.pieces = 1;
  }

  /// Whether all indices are valid and the invariants of the class hold. The digest does not show
  /// that: whoever changes a map can compute it.
  static bool is_valid(const SubmapSlamSystem::Engine& e, const Loops& pending) {
    const SubmapGraph& m = e.map_;
    if (!has_valid_motion(e)) return false;
    if (m.nodes.empty())
      return m.submaps.empty() && m.graph.poses.empty() && m.graph.edges.empty() &&
             pending.edges.empty() && e.scans_.empty() && e.forgotten_.empty() &&
             e.nodes_since_search_ == 0;
    return has_valid_poses(m) && has_valid_edges(m.graph, m.graph.edges) &&
           has_valid_edges(m.graph, pending.edges) && has_valid_submaps(m) && has_valid_scans(e) &&
           has_valid_pieces(e);
  }

 private:
  static bool has_valid_motion(const SubmapSlamSystem::Engine& e) {
    return MotionState::is_valid(e.motion_model_, !e.map_.nodes.empty()) &&
           is_near(e.T_local_base_) && is_count(e.lost_) && is_count(e.nodes_since_search_) &&
           is_positive_semidefinite(e.since_node_) && is_positive_semidefinite(e.since_match_);
  }
  /// With the nodes of the map.
  static bool has_valid_pieces(const SubmapSlamSystem::Engine& e) {
    const SubmapPieces& p = e.pieces_;
    const auto is_edge = [&](const PoseEdge<SE2d>& x) {
      return in(x.from, e.map_.nodes.size()) && in(x.to, e.map_.nodes.size()) &&
             is_near(x.measurement) && is_information(x.information);
    };
    return detail::LossState::is_valid(p.loss) && p.usual_score_ >= 0.0 && p.usual_score_ <= 1.0 &&
           std::ranges::all_of(p.nodes_.possible_joins(), is_edge) &&
           (p.nodes_.all_pieces().empty() ||
            detail::has_valid_pieces(p.nodes_, static_cast<int>(e.map_.nodes.size())));
  }
  /// Every pose is that of one node or one submap.
  static bool has_valid_poses(const SubmapGraph& m) {
    const std::size_t poses = m.graph.poses.size();
    std::vector<char> taken(poses, 0);
    const auto take = [&](const auto& owner) {
      return in(owner.pose, poses) &&
             !std::exchange(taken[static_cast<std::size_t>(owner.pose)], 1);
    };
    return poses == m.nodes.size() + m.submaps.size() &&
           std::ranges::all_of(m.graph.poses, is_near) && std::ranges::all_of(m.nodes, take) &&
           std::ranges::all_of(m.submaps, take) &&
           std::ranges::all_of(m.nodes, [](const SubmapNode& n) {
             return is_near(n.T_local_node) && n.points->xy().size() % 2 == 0;
           });
  }
  /// In the order in which they began, each later one at a later node; those that are not finished
  /// are the last ones and reach to the latest node.
  static bool has_valid_submaps(const SubmapGraph& m) {
    constexpr auto kLastId = std::numeric_limits<std::int64_t>::max() / 2;
    const auto wrong = [](const Submap& a, const Submap& b) {
      return a.id >= b.id || a.first >= b.first || (!a.finished && b.finished);
    };
    return !m.submaps.empty() && m.submaps.front().first == 0 && m.submaps.front().id >= 0 &&
           !m.submaps.back().finished && m.submaps.back().id < m.next_id_ && m.next_id_ < kLastId &&
           std::ranges::adjacent_find(m.submaps, wrong) == m.submaps.end() &&
           std::ranges::all_of(m.submaps, [&](const Submap& s) {
             return in(s.last, m.nodes.size()) && s.first <= s.last && is_near(s.T_local_submap) &&
                    (s.finished || s.last == m.latest());
           });
  }
  static bool has_valid_scans(const SubmapSlamSystem::Engine& e) {
    using std::ranges::is_sorted;
    return !e.scans_.empty() && is_sorted(e.scans_, {}, &ScanPose::time) &&
           is_sorted(e.forgotten_, {}, &StampedPose::time) &&
           is_sorted(e.scans_, {}, &ScanPose::node) &&
           std::ranges::all_of(e.scans_, [&](const ScanPose& s) {
             return in(s.node, e.map_.nodes.size()) && is_near(s.T_node_base);
           });
  }
};

std::vector<std::uint8_t> SubmapSlamSystem::Engine::save() {
  StateWriter a;
  a.number(kMagic);
  field(a, matcher_);
  Loops pending = search_.result();
  if (!join_at_) pending = {};
  SubmapState::all_fields(a, *this, pending);
  SubmapState::errors(a, *this, pending);
  SubmapState::pieces(a, *this);
  return std::move(a).finished();
}

Result<void> SubmapSlamSystem::Engine::restore(std::span<const std::uint8_t> bytes) {
  const auto opened =
      open_state(bytes, {kMagic, kOnePiece, kNoMatcher}, "a map saved by submap SLAM");
  if (!opened) return opened.error();
  const auto& [magic, content] = *opened;
  StateReader a(content);
  std::string matcher = matcher_;
  if (magic != kNoMatcher) field(a, matcher);
  if (matcher != matcher_)
    return state_fault("saved with the matcher \"" + matcher + "\", not with \"" + matcher_ + "\"",
                       sizeof(std::uint64_t));
  Loops pending;
  SubmapState::all_fields(a, *this, pending);
  if (magic != kNoMatcher) SubmapState::errors(a, *this, pending);
  if (magic == kMagic)
    SubmapState::pieces(a, *this);
  else
    SubmapState::begin_pieces(*this);
  if (!a.ok() || a.left() != 0 || !SubmapState::is_valid(*this, pending))
    return state_fault("values that are not a valid map", sizeof(std::uint64_t) + a.at());
  pieces_.follow(map_);
  pieces_.hold_parts(map_);
  search_.set_result(std::move(pending));
  local_.T_local_base = OdomPose(T_local_base_);
  return map_.nodes.empty() ? Result<void>() : tracker_.follow(map_);
}

}  // namespace wayfare
