#include "slam/submap_slam/engine.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <Eigen/LU>

#include <wayfare/map/voxel_filter.hpp>
#include <wayfare/slam/detail/scans.hpp>

namespace wayfare {
namespace {

constexpr std::size_t kFewestPoints = 10;  // of a scan that says where it is

SubmapSlamOptions with_valid_counts(SubmapSlamOptions o) {
  detail::limit_counts({&o.submap_nodes, &o.lost_scans, &o.lost_scans_without_odometry,
                        &o.nodes_between_loops, &o.loop_latency_scans, &o.loop_context_nodes,
                        &o.loops_per_search, &o.tables_kept, &o.max_submaps, &o.max_forgotten_poses,
                        &o.threads});
  return o;
}

}  // namespace

SubmapSlamSystem::Engine::Engine(const SubmapSlamOptions& options, detail::SubmapMaps maps)
    : options_(with_valid_counts(options)),
      matcher_(std::move(maps.matcher)),
      motion_model_(options.odometry, options.constant_velocity),
      tracker_(options_, std::move(maps.growing)),
      search_(options_, std::move(maps.finished)),
      pieces_(options_),
      uncertainty_(options_) {}

Result<ScanOutcome> SubmapSlamSystem::Engine::add(const LaserScan& scan, const MotionHint& hint) {
  const auto odometry = detail::raw(hint.odometry);
  if (auto ok = detail::check_scan(scan, odometry, scans_); !ok) return ok.error();
  if (hint.turn && !std::isfinite(hint.turn->radians()))
    return Error{ErrorCode::invalid, "the gyroscope's heading change is not finite"};
  const auto points = points_of(scan);
  if (!points) return points.error();
  const std::size_t before = map_.nodes.size();
  Motion motion = predict(scan.time, odometry, hint.turn);
  std::optional<Motion> by_velocity;
  if (odometry) by_velocity = predict(scan.time, {}, hint.turn);
  const bool leaped = before > 0 && leaps(motion, by_velocity, hint, scan.time);
  if (leaped && by_velocity) motion = *std::exchange(by_velocity, std::nullopt);
  Result<Placed> found = Placed{odometry.value_or(SE2d()), 0.0, true};
  MatcherErrors errors;
  if (before > 0) found = place(*points, motion, by_velocity, errors);
  if (!found) return found.error();
  Placed& placed = *found;
  ScanOutcome outcome;
  outcome.matcher_errors.add(errors, "scan");
  statistics_.matcher_errors.add(outcome.matcher_errors);
  if (join_at_ && statistics_.scans >= *join_at_) join_loops(outcome);
  const SE2d expected = T_local_base_ * motion.increment;
  const Tracking tracking = judge(placed, motion, leaped, points->size(), scan.time);
  if (!tracking.sure) placed = {expected, placed.score};
  move(motion, placed);
  outcome.score = placed.score;
  outcome.matched = placed.matched;
  if (tracking.lost) {
    if (auto ok = begin_piece(*points, motion, leaped); !ok) return ok.error();
    pieces_.loss.begin(scan.time);
  } else {
    pieces_.loss.add(scan.time, placed.matched, motion, expected.inverse() * T_local_base_);
    if (is_due(placed.matched))
      if (auto ok = add_node(*points, placed); !ok) return ok.error();
  }
  local_ = {OdomPose(T_local_base_), placed.matched, placed.openness, placed.covariance,
            placed.predicted_sigma};
  motion_model_.update(scan.time, T_local_base_, odometry);
  outcome.became_node = map_.nodes.size() > before;
  scans_.push_back(
      {scan.time, map_.latest(), map_.nodes.back().T_local_node.inverse() * T_local_base_});
  if (outcome.became_node) join_pieces();
  outcome.T_map_base = MapPose(map_.pose(map_.latest()) * scans_.back().T_node_base);
  ++statistics_.scans;
  statistics_.unmatched_scans += outcome.matched ? 0 : 1;
  if (outcome.became_node) begin_search();
  return outcome;
}

bool SubmapSlamSystem::Engine::leaps(const Motion& motion, const std::optional<Motion>& by_velocity,
                                     const MotionHint& hint, LogTime time) const {
  return hint.leaped ||
         (by_velocity &&
          detail::LossDetector::leaps(motion, *by_velocity, to_seconds(time - scans_.back().time)));
}

/// Of a scan after `motion`: where odometry leaps, or there is none, it must agree as others did.
SubmapSlamSystem::Engine::Tracking SubmapSlamSystem::Engine::judge(const Placed& placed,
                                                                   const Motion& motion,
                                                                   bool leaped, std::size_t points,
                                                                   LogTime time) {
  statistics_.odometry_leaps += leaped ? 1 : 0;
  if (map_.nodes.empty()) {
    statistics_.pieces = 1;
    pieces_.loss.begin(time);
    return {};
  }
  pieces_.loss.expect(time);
  const bool is_off = !motion.measured && !leaped && options_.lost_scans_without_odometry == 0;
  if (is_off || points < kFewestPoints) return {};
  const bool is_usual = placed.matched && pieces_.is_usual(placed.score, map_);
  const bool measured = motion.measured && !leaped;
  const bool sure =
      measured ? placed.matched : is_usual && (leaped || !pieces_.loss.gap().is_break());
  if (sure) pieces_.add_score(placed.score);
  const bool lost = pieces_.loss.is_lost(sure, motion) || (leaped && !sure);
  return {lost, measured || sure};
}

/// With the latest scan, at its predicted pose; those since the last that was matched belong to it.
Result<void> SubmapSlamSystem::Engine::begin_piece(const PointSet& points, const Motion& motion,
                                                   bool leaped) {
  constexpr double kMargin_m = 1.0;
  const bool is_near = !motion.measured && !leaped;
  const double reach_m = is_near ? pieces_.loss.gap().reach()[0] + kMargin_m : 0.0;
  const int before = map_.latest();
  const SE2d T_before_first = map_.nodes.back().T_local_node.inverse() * T_local_base_;
  map_.add_first_node(pieces_.beside(map_), T_local_base_,
                      std::make_shared<const PackedPoints>(points));
  pieces_.begin(map_, T_before_first, reach_m);
  ++statistics_.pieces;
  for (auto s = scans_.rbegin(); s != scans_.rend() && s->time > pieces_.loss.matched_at(); ++s)
    if (s->node == before) *s = {s->time, map_.latest(), T_before_first.inverse() * s->T_node_base};
  return node_added(true);
}

void SubmapSlamSystem::Engine::join_pieces() {
  if (!pieces_.are_several()) return;
  pieces_.follow(map_);
  while (pieces_.join_latest(map_)) {
    ++statistics_.joins;
    (void)optimise(20, 1e-5);  // on failure the poses are unchanged
  }
  pieces_.count(statistics_);
}

/// Within range, one per voxel; finite by LaserScan::returned.
Result<PointSet> SubmapSlamSystem::Engine::points_of(const LaserScan& scan) const {
  const double range = std::min(options_.max_range_m, PackedPoints::kMaxRange_m);
  return voxel_filter(
      thin(end_points(scan, options_.T_base_laser.raw()), 0.0F, static_cast<float>(range)),
      options_.voxel_m);
}

Motion SubmapSlamSystem::Engine::predict(LogTime time, const std::optional<SE2d>& odometry,
                                         const std::optional<Angle>& turn) const {
  const Motion motion = motion_model_.predict(time, odometry);
  if (!turn) return motion;
  Eigen::Vector3d by_gyro = motion.sigma;
  by_gyro[2] = options_.gyro_floor.radians() + options_.gyro_per_rad * std::abs(turn->radians());
  const auto sigma = at_least_rounding(by_gyro);
  if (!sigma) return motion;
  return {SE2d(motion.increment.translation(), SO2d(*turn)), *sigma, motion.measured};
}

/// Matches around the prediction `motion`. If that is odometry, contradicts `by_velocity` and
/// agrees poorly, tries the latter too: counters are reset, wheels lifted.
Result<SubmapSlamSystem::Engine::Placed> SubmapSlamSystem::Engine::place(
    const PointSet& points, const Motion& motion, const std::optional<Motion>& by_velocity,
    MatcherErrors& errors) const {
  const SE2d expected = T_local_base_ * motion.increment;
  // After unmatched scans the error may exceed that of one motion.
  const Eigen::Vector3d most(1.0, 1.0, Angle::degrees(60).radians());
  const Eigen::Vector3d sigma =
      motion.accumulated(since_match_).diagonal().cwiseSqrt().cwiseMin(most);
  auto found = tracker_.place(map_, points, expected, {motion.increment, sigma}, errors);
  if (!found) return found.error();
  const bool poor = !*found || (*found)->score < options_.tracked_score;
  if (by_velocity && (poor || jumps(motion, *by_velocity)) &&
      contradicts(motion, *by_velocity, options_.search_sigmas)) {
    constexpr double kMargin = 0.05;
    const auto other =
        tracker_.place(map_, points, T_local_base_ * by_velocity->increment, *by_velocity, errors);
    if (!other) return other.error();
    if (*other && (*other)->score > (*found ? (*found)->score : 0.0) + kMargin) found = other;
  }
  if (!*found) return Placed{expected};
  const LocalTracker::Placement& best = **found;
  return Placed{best.T_local_points, best.score, true, best.covariance, best.openness, sigma};
}

/// To the pose of a scan after `motion`.
void SubmapSlamSystem::Engine::move(const Motion& motion, const Placed& placed) {
  since_node_ = motion.accumulated(since_node_);
  since_match_ = motion.accumulated(since_match_);
  if (placed.matched) since_match_.setZero();
  placed_ = placed.matched ? placed.covariance : motion.accumulated(placed_);
  T_local_base_ = placed.T_local_base;
  lost_ = placed.matched ? 0 : lost_ + 1;
}

/// An unmatched scan becomes a node only after several in a row.
bool SubmapSlamSystem::Engine::is_due(bool matched) const {
  if (map_.nodes.empty()) return true;
  if (!matched) return lost_ >= options_.lost_scans;
  return reaches(map_.nodes.back().T_local_node.inverse() * T_local_base_, options_.node_distance_m,
                 options_.node_turn);
}

Result<void> SubmapSlamSystem::Engine::add_node(const PointSet& points, const Placed& placed) {
  if (!map_.nodes.empty() && !placed.matched && points.size() < kFewestPoints) return {};
  const auto packed = std::make_shared<const PackedPoints>(points);
  if (map_.nodes.empty()) {
    map_.add_first_node(T_local_base_, T_local_base_, packed);
  } else {
    join_node(packed, placed);
  }
  return node_added(!placed.matched);
}

Result<void> SubmapSlamSystem::Engine::node_added(bool lost) {
  since_node_.setZero();
  since_match_.setZero();
  lost_ = 0;
  if (lost) placed_.setZero();
  ++statistics_.nodes;
  return end_submaps(lost);
}

/// Joined to the previous node by match and motion, and to the submap by the match; at poor
/// agreement only to the previous node, weakly.
void SubmapSlamSystem::Engine::join_node(const std::shared_ptr<const PackedPoints>& points,
                                         const Placed& placed) {
  const SubmapNode& before = map_.nodes.back();
  const SE2d step = before.T_local_node.inverse() * T_local_base_;
  const double d = step.translation().norm(), turn = std::abs(step.heading().radians());
  const Eigen::Matrix3d by_motion = since_node_.inverse();
  if (placed.score < options_.tracked_score) {
    map_.add_node(T_local_base_, points, placed.matched ? weak_information(d, turn) : by_motion);
    return;
  }
  const Submap& submap = matched_submap(map_);
  const double since_first = before.travel_m + d - map_.node(submap.first).travel_m;
  map_.add_node(T_local_base_, points, by_motion + match_information(placed.covariance, d, turn));
  map_.join_latest(submap, match_information(placed.covariance, since_first, 0.0));
}

/// Adds the latest node to the unfinished submaps. A full one is finished, at half of it another
/// starts. If the robot was lost all are finished.
Result<void> SubmapSlamSystem::Engine::end_submaps(bool lost) {
  int unfinished = 0;
  for (Submap& s : map_.submaps) {
    if (s.finished) continue;
    if (lost) {
      s.finished = true;
      continue;
    }
    s.last = map_.latest();
    ++unfinished;
    s.finished = s.last - s.first + 1 >= options_.submap_nodes;
  }
  const bool half = unfinished > 0 && map_.submaps.back().last - map_.submaps.back().first + 1 >=
                                          std::max(options_.submap_nodes / 2, 1);
  if (unfinished == 0 || half) {
    map_.begin_submap();
    ++statistics_.submaps;
  }
  return tracker_.follow(map_);
}

void SubmapSlamSystem::Engine::begin_search() {
  if (join_at_ || ++nodes_since_search_ < options_.nodes_between_loops) return;
  nodes_since_search_ = 0;
  forget();
  if (search_.begin(map_, pieces_.first_of_latest()))
    join_at_ = statistics_.scans + static_cast<std::uint64_t>(options_.loop_latency_scans);
}

void SubmapSlamSystem::Engine::join_loops(ScanOutcome& outcome) {
  join_at_.reset();
  const Loops& found = search_.result();
  map_.graph.edges.insert(map_.graph.edges.end(), found.edges.begin(), found.edges.end());
  statistics_.loop_closures += found.edges.size();
  statistics_.loops_refused += found.refused;
  statistics_.matcher_errors.add(found.errors, "loop");
  outcome.loop_closures = static_cast<int>(found.edges.size());
  outcome.matcher_errors.add(found.errors, "loop");
  if (!found.edges.empty()) (void)optimise(5, 1e-4);  // on failure the poses are unchanged
}

/// Only without a running search: its edges refer to poses.
void SubmapSlamSystem::Engine::forget() {
  const auto finished = [&] {
    return std::count_if(map_.submaps.begin(), map_.submaps.end(),
                         [](const Submap& s) { return s.finished; });
  };
  while (options_.max_submaps > 0 && finished() > options_.max_submaps) {
    const int gone = map_.submaps[1].first;
    const auto kept = std::find_if(scans_.begin(), scans_.end(),
                                   [&](const ScanPose& s) { return s.node >= gone; });
    for (auto s = scans_.begin(); s != kept; ++s)
      forgotten_.push_back({s->time, MapPose(map_.pose(s->node) * s->T_node_base)});
    scans_.erase(scans_.begin(), kept);
    const auto most = static_cast<std::size_t>(options_.max_forgotten_poses);
    if (most > 0 && forgotten_.size() > most)
      forgotten_.erase(forgotten_.begin(), forgotten_.end() - std::ptrdiff_t(most));
    for (ScanPose& s : scans_) s.node -= gone;
    pieces_.forget(map_.forget_oldest());
    pieces_.hold_parts(map_);
    search_.poses_dropped();
    ++statistics_.forgotten_submaps;
  }
}

Result<void> SubmapSlamSystem::Engine::optimise(int iterations, double min_gain) {
  pieces_.moved();
  return wayfare::optimise(optimiser_, map_.graph, loop_kernel(options_.loop_kernel_sigmas),
                           iterations, min_gain, statistics_.optimisations);
}

Result<void> SubmapSlamSystem::Engine::finish_all() {
  ScanOutcome of_none;
  if (join_at_) join_loops(of_none);
  // Search once more, for loops closed by the very last nodes.
  if (nodes_since_search_ > 0 && search_.begin(map_, pieces_.first_of_latest()))
    join_loops(of_none);
  if (map_.nodes.size() < 2) return {};
  while (pieces_.join_all(map_)) {
    ++statistics_.joins;
    (void)optimise(20, 1e-5);
  }
  if (auto ok = optimise(50, 1e-6); !ok) return ok;
  pieces_.place_small_parts(map_);
  pieces_.count(statistics_);
  statistics_.scans_apart = static_cast<std::size_t>(std::ranges::count_if(
      scans_, [&](const ScanPose& s) { return pieces_.is_in_small_part(s.node); }));
  return {};
}

}  // namespace wayfare
