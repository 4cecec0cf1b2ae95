#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/LU>

#include <wayfare/core/detail/bytes.hpp>
#include <wayfare/core/gaussian.hpp>

#include "slam/submap_slam/engine.hpp"

namespace wayfare {
namespace {

// The formats, least byte first. The earlier one does not tell the matcher, nor its errors.
constexpr std::uint64_t kMagic = 0x33'50'41'4d'42'55'53'57;         // "WSUBMAP3"
constexpr std::uint64_t kEarlierMagic = 0x32'50'41'4d'42'55'53'57;  // "WSUBMAP2"

/// FNV-1a, to detect a damaged file.
std::uint64_t digest(std::span<const std::uint8_t> bytes) {
  std::uint64_t hash = 0xcbf29ce484222325;
  for (const std::uint8_t b : bytes) hash = (hash ^ b) * 0x100000001b3;
  return hash;
}

bool in(int index, std::size_t size) {
  return index >= 0 && static_cast<std::size_t>(index) < size;
}

/// Of a counter that is still to be increased.
bool is_count(int n) { return n >= 0 && n < std::numeric_limits<int>::max() / 2; }

/// Whether search and optimisation can use it: it and its inverse are positive definite.
bool is_information(const Eigen::Matrix3d& m) {
  const auto definite = [](const Eigen::Matrix3d& x) {
    return x.allFinite() && Eigen::LLT<Eigen::Matrix3d>(x).info() == Eigen::Success;
  };
  return definite(m) && definite(m.inverse());
}

/// Beyond it sums of poses lose their meaning, and products of them may overflow.
constexpr double kFarthest_m = 1e12;

bool is_near(const SE2d& pose) { return pose.translation().cwiseAbs().maxCoeff() < kFarthest_m; }

// Serialisation with one list of fields for both directions: little endian, every vector preceded
// by its length.

class StateWriter {
 public:
  static constexpr bool kReads = false;
  std::vector<std::uint8_t> bytes;

  template <decode::Number T>
  void number(const T& value) {
    bytes.resize(bytes.size() + sizeof(T));
    decode::store_le(value, bytes.data() + bytes.size() - sizeof(T));
  }
  [[nodiscard]] static bool ok() { return true; }
};

/// Stops reading at the first fault.
class StateReader {
 public:
  static constexpr bool kReads = true;
  explicit StateReader(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}

  template <decode::Number T>
  void number(T& value) {
    if (!ok_ || left() < sizeof(T)) return fail();
    value = decode::load_le<T>(bytes_.data() + at_);
    at_ += sizeof(T);
    if constexpr (std::floating_point<T>)
      if (!std::isfinite(value)) fail();
  }
  void fail() { ok_ = false; }
  [[nodiscard]] bool ok() const { return ok_; }
  [[nodiscard]] std::size_t at() const { return at_; }
  [[nodiscard]] std::size_t left() const { return bytes_.size() - at_; }

 private:
  std::span<const std::uint8_t> bytes_;
  std::size_t at_ = 0;
  bool ok_ = true;
};

template <class A, decode::Number T>
void field(A& a, T& value) {
  a.number(value);
}
template <class A>
void field(A& a, bool& value) {
  std::uint8_t byte = value ? 1 : 0;
  a.number(byte);
  value = byte != 0;
}
template <class A>
void field(A& a, LogTime& time) {
  std::int64_t ns = time.nanoseconds();
  a.number(ns);
  time = LogTime::from_nanoseconds(ns);
}
template <class A, int R, int C>
void field(A& a, Eigen::Matrix<double, R, C>& m) {
  for (double& x : m.reshaped()) a.number(x);
}
template <class A>
void field(A& a, SE2d& pose) {
  double v[4] = {pose.x(), pose.y(), pose.rotation().cos(), pose.rotation().sin()};
  for (double& x : v) a.number(x);
  if constexpr (A::kReads) {
    if (!(std::abs(v[2] * v[2] + v[3] * v[3] - 1) < 1e-6)) return a.fail();
    pose = SE2d(Eigen::Vector2d(v[0], v[1]), SO2d::from_unit_complex(v[2], v[3]));
  }
}
template <class A, class... T>
void fields(A& a, T&... values) {
  (field(a, values), ...);
}
template <class A, class T, class Each>
void each(A& a, std::vector<T>& values, const Each& one) {
  std::uint64_t n = values.size();
  a.number(n);
  if constexpr (A::kReads) {
    if (!a.ok() || n > a.left()) return a.fail();  // every value takes at least one byte
    values.clear();
    for (std::uint64_t i = 0; i < n && a.ok(); ++i) one(values.emplace_back());
  } else {
    for (T& value : values) one(value);
  }
}
template <class A>
void field(A& a, std::string& text) {
  std::vector<char> letters(text.begin(), text.end());
  each(a, letters, [&](char& c) {
    auto byte = static_cast<std::uint8_t>(c);
    a.number(byte);
    c = static_cast<char>(byte);
  });
  text.assign(letters.begin(), letters.end());
}
template <class A>
void field(A& a, MatcherErrors& errors) {
  field(a, errors.count);
  field(a, errors.first);
}
template <class A, class T, class Inner>
void optional_field(A& a, std::optional<T>& value, const Inner& inner) {
  bool has = value.has_value();
  field(a, has);
  if constexpr (A::kReads) value = has ? std::optional<T>(T{}) : std::nullopt;
  if (has) inner(*value);
}

}  // namespace

/// The fields of a SubmapSlamSystem.
struct SubmapState {
  template <class A>
  static void edges(A& a, std::vector<PoseEdge<SE2d>>& edges) {
    each(a, edges, [&](PoseEdge<SE2d>& e) {
      fields(a, e.from, e.to, e.measurement, e.information, e.robust);
    });
  }

  template <class A>
  static void map(A& a, SubmapGraph& map) {
    each(a, map.graph.poses, [&](SE2d& pose) { field(a, pose); });
    edges(a, map.graph.edges);
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
  static void motion(A& a, MotionModel& model) {
    optional_field(a, model.last_, [&](auto& last) {
      fields(a, last.time, last.pose);
      optional_field(a, last.odometry, [&](SE2d& pose) { field(a, pose); });
    });
    fields(a, model.velocity_from_.time, model.velocity_from_.pose, model.mean_interval_s_,
           model.velocity_);
  }

  template <class A>
  static void path(A& a, SubmapSlamSystem::Engine& e) {
    each(a, e.forgotten_, [&](StampedPose& p) {
      field(a, p.time);
      SE2d pose = p.T_map_base.raw();
      field(a, pose);
      p.T_map_base = MapPose(pose);
    });
    each(a, e.scans_, [&](ScanPose& s) { fields(a, s.time, s.node, s.T_node_base); });
  }

  template <class A>
  static void all_fields(A& a, SubmapSlamSystem::Engine& e, Loops& pending) {
    map(a, e.map_);
    motion(a, e.motion_model_);
    path(a, e);
    fields(a, e.T_local_base_, e.since_node_, e.since_match_, e.lost_, e.nodes_since_search_);
    optional_field(a, e.join_at_, [&](std::uint64_t& n) { field(a, n); });
    edges(a, pending.edges);
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
           has_valid_edges(m.graph, pending.edges) && has_valid_submaps(m) && has_valid_scans(e);
  }

 private:
  static bool has_valid_motion(const SubmapSlamSystem::Engine& e) {
    const MotionModel& m = e.motion_model_;
    return m.last_.has_value() == !e.map_.nodes.empty() &&
           (!m.last_ || (is_near(m.last_->pose) && is_near(m.last_->odometry.value_or(SE2d())))) &&
           is_near(m.velocity_from_.pose) && m.mean_interval_s_ >= 0.0 &&
           m.velocity_.cwiseAbs().maxCoeff() < kFarthest_m && is_near(e.T_local_base_) &&
           is_count(e.lost_) && is_count(e.nodes_since_search_) &&
           is_positive_semidefinite(e.since_node_) && is_positive_semidefinite(e.since_match_);
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
  static bool has_valid_edges(const PoseGraph2& graph, const std::vector<PoseEdge<SE2d>>& edges) {
    const std::size_t poses = graph.poses.size();
    return std::ranges::all_of(edges, [&](const PoseEdge<SE2d>& x) {
      return in(x.from, poses) && in(x.to, poses) && x.from != x.to && is_near(x.measurement) &&
             is_information(x.information);
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
  a.number(digest(a.bytes));
  return std::move(a.bytes);
}

Result<void> SubmapSlamSystem::Engine::restore(std::span<const std::uint8_t> bytes) {
  const auto fault = [](const std::string& what, std::size_t at) {
    return Error{ErrorCode::parse, what, "saved map", 0, at};
  };
  constexpr std::size_t kFrame = 2 * sizeof(std::uint64_t);
  const std::uint64_t magic =
      bytes.size() < kFrame ? 0 : decode::load_le<std::uint64_t>(bytes.data());
  if (magic != kMagic && magic != kEarlierMagic) return fault("not a map saved by submap SLAM", 0);
  const auto content = bytes.first(bytes.size() - sizeof(std::uint64_t));
  if (decode::load_le<std::uint64_t>(bytes.data() + content.size()) != digest(content))
    return fault("damaged or truncated: the digest at its end does not match", content.size());
  StateReader a(content.subspan(sizeof(std::uint64_t)));
  std::string matcher = matcher_;
  if (magic == kMagic) field(a, matcher);
  if (matcher != matcher_)
    return fault("saved with the matcher \"" + matcher + "\", not with \"" + matcher_ + "\"",
                 sizeof(std::uint64_t));
  Loops pending;
  SubmapState::all_fields(a, *this, pending);
  if (magic == kMagic) SubmapState::errors(a, *this, pending);
  if (!a.ok() || a.left() != 0 || !SubmapState::is_valid(*this, pending))
    return fault("values that are not a valid map", sizeof(std::uint64_t) + a.at());
  search_.set_result(std::move(pending));
  local_.T_local_base = OdomPose(T_local_base_);
  return map_.nodes.empty() ? Result<void>() : tracker_.follow(map_);
}

}  // namespace wayfare
