#include <algorithm>
#include <string>

#include "slam/submap_slam/engine.hpp"
#include "slam/submap_slam/state_bytes.hpp"

namespace wayfare {
namespace {

constexpr std::uint64_t kMagic = 0x32'50'41'4d'42'55'53'57;  // "WSUBMAP2", least byte first

/// FNV-1a, to detect a damaged file.
std::uint64_t digest(std::span<const std::uint8_t> bytes) {
  std::uint64_t hash = 0xcbf29ce484222325;
  for (const std::uint8_t b : bytes) hash = (hash ^ b) * 0x100000001b3;
  return hash;
}

bool in(int index, std::size_t size) {
  return index >= 0 && static_cast<std::size_t>(index) < size;
}

}  // namespace

/// The fields of a SubmapSlam.
struct SubmapState {
  template <class A>
  static void edges(A& a, std::vector<PoseEdge<SE2d>>& edges) {
    each(a, edges, [&](PoseEdge<SE2d>& e) {
      field(a, e.from);
      field(a, e.to);
      field(a, e.measurement);
      field(a, e.information);
      field(a, e.robust);
    });
  }

  template <class A>
  static void map(A& a, SubmapGraph& map) {
    each(a, map.graph.poses, [&](SE2d& pose) { field(a, pose); });
    edges(a, map.graph.edges);
    each(a, map.nodes, [&](SubmapNode& n) {
      field(a, n.pose);
      field(a, n.T_local_node);
      field(a, n.travel_m);
      std::vector<std::int16_t> xy;
      if constexpr (!A::kReads) xy = n.points->xy();
      each(a, xy, [&](std::int16_t& t) { field(a, t); });
      if constexpr (A::kReads) n.points = std::make_shared<const PackedPoints>(std::move(xy));
    });
    each(a, map.submaps, [&](Submap& s) {
      field(a, s.id);
      field(a, s.pose);
      field(a, s.T_local_submap);
      field(a, s.first);
      field(a, s.last);
      field(a, s.finished);
    });
    field(a, map.next_id_);
  }

  template <class A>
  static void motion(A& a, MotionModel& model) {
    optional_field(a, model.last_, [&](auto& last) {
      field(a, last.time);
      field(a, last.pose);
      optional_field(a, last.odometry, [&](SE2d& pose) { field(a, pose); });
    });
    field(a, model.velocity_from_.time);
    field(a, model.velocity_from_.pose);
    field(a, model.mean_interval_s_);
    field(a, model.velocity_);
  }

  template <class A>
  static void path(A& a, SubmapSlam::Engine& e) {
    each(a, e.forgotten_, [&](StampedPose& p) {
      field(a, p.time);
      SE2d pose = p.T_map_base.raw();
      field(a, pose);
      p.T_map_base = Transform2<frame::Map, frame::Base>(pose);
    });
    each(a, e.scans_, [&](SubmapScan& s) {
      field(a, s.time);
      field(a, s.node);
      field(a, s.T_node_base);
    });
  }

  template <class A>
  static void all_fields(A& a, SubmapSlam::Engine& e, FoundLoops& pending) {
    map(a, e.map_);
    motion(a, e.motion_model_);
    path(a, e);
    field(a, e.T_local_base_);
    field(a, e.since_node_);
    field(a, e.since_match_);
    field(a, e.lost_);
    field(a, e.nodes_since_search_);
    optional_field(a, e.join_at_, [&](std::uint64_t& n) { field(a, n); });
    edges(a, pending.edges);
    SubmapSlamStatistics& s = e.statistics_;
    for (std::size_t* n :
         {&pending.refused, &s.scans, &s.unmatched_scans, &s.nodes, &s.submaps,
          &s.forgotten_submaps, &s.loop_closures, &s.loops_refused, &s.optimisations})
      field(a, *n);
  }

  /// Whether all indices are valid and the invariants hold.
  static bool is_valid(const SubmapSlam::Engine& e, const FoundLoops& pending) {
    const SubmapGraph& m = e.map_;
    const std::size_t poses = m.graph.poses.size(), nodes = m.nodes.size();
    const auto edge = [&](const PoseEdge<SE2d>& x) { return in(x.from, poses) && in(x.to, poses); };
    const auto all = [](const auto& values, const auto& good) {
      return std::all_of(values.begin(), values.end(), good);
    };
    if (m.nodes.empty())
      return m.submaps.empty() && poses == 0 && m.graph.edges.empty() && e.scans_.empty();
    return all(m.graph.edges, edge) && all(pending.edges, edge) &&
           all(m.nodes,
               [&](const SubmapNode& n) {
                 return in(n.pose, poses) && n.points->xy().size() % 2 == 0;
               }) &&
           all(m.submaps,
               [&](const Submap& s) {
                 return in(s.pose, poses) && in(s.first, nodes) && in(s.last, nodes) &&
                        s.first <= s.last;
               }) &&
           !m.submaps.empty() && !m.submaps.back().finished && !e.scans_.empty() &&
           all(e.scans_, [&](const SubmapScan& s) { return in(s.node, nodes); });
  }
};

std::vector<std::uint8_t> SubmapSlam::Engine::save() {
  StateWriter a;
  a.number(kMagic);
  FoundLoops pending = search_.result();
  if (!join_at_) pending = {};
  SubmapState::all_fields(a, *this, pending);
  a.number(digest(a.bytes));
  return std::move(a.bytes);
}

Result<void> SubmapSlam::Engine::restore(std::span<const std::uint8_t> bytes) {
  const auto fault = [](const std::string& what, std::size_t at) {
    return Error{ErrorCode::parse, what, "saved map", 0, at};
  };
  constexpr std::size_t kFrame = 2 * sizeof(std::uint64_t);
  if (bytes.size() < kFrame || decode::load_le<std::uint64_t>(bytes.data()) != kMagic)
    return fault("not a map saved by submap SLAM", 0);
  const auto content = bytes.first(bytes.size() - sizeof(std::uint64_t));
  if (decode::load_le<std::uint64_t>(bytes.data() + content.size()) != digest(content))
    return fault("damaged or truncated: the digest at its end does not match", content.size());
  StateReader a(content.subspan(sizeof(std::uint64_t)));
  FoundLoops pending;
  SubmapState::all_fields(a, *this, pending);
  if (!a.ok() || a.left() != 0 || !SubmapState::is_valid(*this, pending))
    return fault("values that are not a valid map", sizeof(std::uint64_t) + a.at());
  search_.set_result(std::move(pending));
  return map_.nodes.empty() ? Result<void>() : tracker_.follow(map_);
}

}  // namespace wayfare
