#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include <Eigen/Core>
#include <Eigen/LU>

#include <wayfare/core/detail/call_guard.hpp>
#include <wayfare/core/result.hpp>
#include <wayfare/graph/optimise.hpp>
#include <wayfare/map/inverse_lidar.hpp>
#include <wayfare/slam/detail/graph_slam/local_optimiser.hpp>
#include <wayfare/slam/detail/graph_slam/loop_closer.hpp>
#include <wayfare/slam/detail/graph_slam/loss_detector.hpp>
#include <wayfare/slam/detail/graph_slam/node_map.hpp>
#include <wayfare/slam/detail/graph_slam/node_merger.hpp>
#include <wayfare/slam/detail/graph_slam/piece_joiner.hpp>
#include <wayfare/slam/detail/graph_slam/state.hpp>
#include <wayfare/slam/detail/graph_slam/tracker.hpp>
#include <wayfare/slam/detail/graph_slam/wall_crossings.hpp>
#include <wayfare/slam/detail/loops.hpp>
#include <wayfare/slam/detail/motion.hpp>
#include <wayfare/slam/detail/scans.hpp>
#include <wayfare/slam/graph_slam.hpp>

namespace wayfare::detail {

/// Graph SLAM without its way of matching. `Matching` is made of the options and places scans in
/// maps of nodes: FieldMatching, or MatcherMatching of a matcher.
template <class Matching>
class GraphSlamEngine {
 public:
  /// `make(options)` is the Matching.
  template <class Make>
  GraphSlamEngine(const GraphSlamOptions& options, const Make& make)
      : options_(with_valid_counts(options)),
        motion_model_(options.odometry, options.constant_velocity),
        tracker_(options_, make(options_)),
        loop_closer_(options_, make(options_)),
        joiner_(options_, make(options_)),
        merger_(options_),
        loss_(options_) {}

  Result<ScanOutcome> add_scan(const LaserScan& scan, const std::optional<OdomPose>& odometry) {
    return guard_.run([&] { return add(scan, raw(odometry)); });
  }
  Result<void> finish() {
    return guard_.run([&] { return finish_all(); });
  }

  [[nodiscard]] Trajectory trajectory() const {
    Trajectory result;
    result.reserve(scans_.size());
    for (const ScanPose& s : scans_)
      result.push_back({s.time, MapPose(nodes_.pose(s.node) * s.T_node_base)});
    return result;
  }

  [[nodiscard]] OccupancyGrid map(const OccupancyGridOptions& shape,
                                  const InverseLidarModel& model) const {
    OccupancyGrid grid(shape);
    ScanRaster raster;
    const Eigen::Vector2d laser = options_.T_base_laser.raw().translation();
    for (int k = 0; k < nodes_.size(); ++k) {
      if (is_in_small_part(k)) continue;
      // A scan too large for the raster is left out of the map.
      (void)insert_points(grid, nodes_.pose(k), nodes_.points(k), model, raster, laser);
    }
    return grid;
  }

  /// All of the state but the options and the matching.
  [[nodiscard]] std::vector<std::uint8_t> save() { return detail::save(state()); }
  /// Continues from it; to be discarded after an Error.
  Result<void> restore(std::span<const std::uint8_t> bytes) {
    return detail::restore(state(), bytes);
  }

  [[nodiscard]] const PoseGraph2& graph() const { return nodes_.graph(); }
  [[nodiscard]] const GraphSlamStatistics& statistics() const { return statistics_; }
  [[nodiscard]] WallCrossings wall_crossings(const OccupancyGrid& map) const {
    std::vector<PlacedPoints> all;
    for (int k = 0; k < nodes_.size(); k += 3)
      if (!is_in_small_part(k)) all.push_back({&nodes_.points(k), nodes_.pose(k)});
    return detail::wall_crossings(all, map, options_.T_base_laser.raw().translation());
  }

 private:
  Result<ScanOutcome> add(const LaserScan& scan, const std::optional<SE2d>& odometry) {
    if (auto ok = check_scan(scan, odometry, scans_); !ok) return ok.error();
    const PointSet points = points_of(scan);
    Result<ScanOutcome> placed = nodes_.size() == 0 ? begin(points, scan.time, odometry)
                                                    : track_scan(points, scan.time, odometry);
    if (!placed) return placed;
    ScanOutcome& outcome = *placed;
    motion_model_.update(scan.time, pose_, odometry);
    if (outcome.became_node) {
      close_loops(outcome);
      while (join(joiner_.search_latest(nodes_))) {
      }
    }
    outcome.T_map_base = MapPose(pose_);
    scans_.push_back({scan.time, nodes_.latest(), latest_node().inverse() * pose_});
    merge_nodes();
    count(outcome);
    return placed;
  }

  Result<void> finish_all() {
    if (nodes_.size() < 2) return {};
    ScanOutcome last;
    close_loops(last, true);
    statistics_.matcher_errors.add(last.matcher_errors);
    while (join(joiner_.search_all(nodes_))) {
    }
    if (auto done = optimise_all(); !done) return done;
    joiner_.place_small_parts(nodes_);
    nodes_have_moved(latest_node() * scans_.back().T_node_base);
    joiner_.count(nodes_, statistics_);
    statistics_.scans_apart = static_cast<std::size_t>(
        std::ranges::count_if(scans_, [&](const ScanPose& s) { return is_in_small_part(s.node); }));
    release();
    return {};
  }

  /// Frees the memory of matching and optimisation before the map is drawn.
  void release() {
    tracker_.release();
    optimiser_ = {};
    local_optimiser_ = {};
  }

  GraphSlamState state() {
    return {nodes_,         motion_model_,         loss_,       scans_,
            pose_,          since_node_,           statistics_, loop_closer_.last_searched(),
            merger_.kept(), tracker_.usual_sharp()};
  }
  static GraphSlamOptions with_valid_counts(GraphSlamOptions o) {
    limit_counts({&o.local_nodes, &o.sharp_nodes, &o.nodes_between_loops, &o.loop_gap_nodes,
                  &o.loop_context_nodes, &o.loop_map_nodes, &o.loops_per_search});
    return o;
  }

  /// Whether a node is in a small part of the map, which is not drawn.
  [[nodiscard]] bool is_in_small_part(int k) const {
    if (nodes_.pieces() < 2) return false;
    const int part = nodes_.part_of(k);
    return part != 0 && PieceJoiner<Matching>::is_small(nodes_, part);
  }

  [[nodiscard]] PointSet points_of(const LaserScan& scan) const {
    return thin(end_points(scan, options_.T_base_laser.raw()),
                static_cast<float>(options_.point_spacing_m),
                static_cast<float>(options_.max_range_m));
  }

  /// The first scan is the first node, at the odometry pose.
  ScanOutcome begin(const PointSet& points, LogTime time, const std::optional<SE2d>& odometry) {
    pose_ = odometry.value_or(SE2d());
    nodes_.start(pose_, points);
    loss_.begin(time);
    ScanOutcome outcome;
    outcome.became_node = true;
    return outcome;
  }

  /// Tracks the scan; adds a node if one is due, or begins a piece if tracking is lost. Changes
  /// nothing if the matching is in error.
  Result<ScanOutcome> track_scan(const PointSet& points, LogTime time,
                                 const std::optional<SE2d>& odometry) {
    loss_.expect(time);
    const double holds_s = std::max(kVelocityHolds_s, loss_.gap().usual_s());
    const Motion motion = motion_model_.predict(time, odometry, holds_s);
    const Motion by_velocity = motion_model_.predict(time, {}, holds_s);
    // Scans of few points say nothing.
    const bool is_blind = points.size() < Tracker<Matching>::kFewestPoints;
    if (!is_blind &&
        LossDetector::leaps(motion, by_velocity, to_seconds(time - scans_.back().time))) {
      ++statistics_.odometry_leaps;
      return begin_piece(points, time, by_velocity, 0.0);
    }
    const auto track =
        tracker_.place(nodes_, points, pose_ * motion.increment, motion, loss_.gap());
    const MatcherErrors errors = tracker_.take_errors();
    if (!track) return track.error();
    const auto& [match, widened, sure] = *track;
    const bool found = sure && match.score >= options_.lost_score;
    if (!is_blind && loss_.is_lost(found, motion)) {
      constexpr double kMargin_m = 1.0;
      const double reach_m = motion.measured ? 0.0 : loss_.gap().reach()[0] + kMargin_m;
      return begin_piece(points, time, motion, reach_m);
    }
    loss_.add(time, found, motion, (pose_ * motion.increment).inverse() * match.T_map_points);
    pose_ = match.T_map_points;
    since_node_ = motion.accumulated(since_node_);
    ScanOutcome outcome;
    outcome.matcher_errors.add(errors, "scan");
    outcome.score = match.score;
    outcome.matched = found;
    const SE2d step = latest_node().inverse() * pose_;
    const double travel_m = step.translation().norm();
    const double turn_rad = std::abs(step.heading().radians());
    outcome.became_node =
        sure && (travel_m > options_.node_distance_m || turn_rad > options_.node_turn.radians());
    if (outcome.became_node) {
      nodes_.append(pose_, points, information(match, travel_m, turn_rad));
      since_node_.setZero();
      tracker_.nodes_changed();
    }
    statistics_.widened_searches += widened ? 1 : 0;
    return outcome;
  }

  /// The scan is the first node of a piece, beside the map. `reach_m`: how far it may be from the
  /// pose predicted; 0 if that is not known.
  ScanOutcome begin_piece(const PointSet& points, LogTime time, const Motion& motion,
                          double reach_m) {
    const SE2d predicted = pose_ * motion.increment;
    const SE2d T_before_scan = latest_node().inverse() * predicted;
    const int before = nodes_.latest();
    pose_ = beside();
    motion_model_.correct(pose_ * motion.increment.inverse());
    nodes_.start(pose_, points, T_before_scan, reach_m);
    // Scans since the last that was matched belong to the piece, too.
    for (auto s = scans_.rbegin(); s != scans_.rend() && s->time > loss_.matched_at(); ++s)
      if (s->node == before)
        *s = {s->time, nodes_.latest(), predicted.inverse() * nodes_.pose(before) * s->T_node_base};
    since_node_.setZero();
    tracker_.nodes_changed();
    loss_.begin(time);
    ScanOutcome outcome;
    outcome.became_node = true;
    return outcome;
  }
  /// A pose from which no scan reaches the map.
  [[nodiscard]] SE2d beside() const {
    double x = 0.0;
    for (const SE2d& pose : nodes_.graph().poses) x = std::max(x, pose.x());
    return SE2d(x + 2.0 * options_.max_range_m, 0.0, Angle());
  }

  /// Joins two parts of the map by edges, if there are any.
  bool join(const std::vector<PoseEdge<SE2d>>& edges) {
    if (edges.empty()) return false;
    const SE2d T_node_base = latest_node().inverse() * pose_;
    nodes_.join(edges);
    ++statistics_.joins;
    (void)optimise(20, 1e-5, optimiser_);
    nodes_have_moved(latest_node() * T_node_base);
    return true;
  }

  void merge_nodes() {
    const int removed = merger_.update(nodes_, scans_);
    if (removed == 0) return;
    loop_closer_.nodes_removed(removed);
    joiner_.nodes_changed();
  }

  /// Of the edge to a new node: that of the match, plus that of odometry along directions the match
  /// does not constrain.
  [[nodiscard]] Eigen::Matrix3d information(const Placement& match, double travel_m,
                                            double turn_rad) const {
    if (match.score < options_.lost_score) return weak_information(travel_m, turn_rad);
    return match_information(match, pose_.rotation(), 0.02 + 0.02 * travel_m,
                             Angle::degrees(0.4).radians() + 0.02 * turn_rad) +
           since_node_.inverse();
  }

  void close_loops(ScanOutcome& outcome, bool is_last = false) {
    const Loops loops = loop_closer_.search(nodes_, is_last);
    auto& edges = nodes_.graph().edges;
    edges.insert(edges.end(), loops.edges.begin(), loops.edges.end());
    statistics_.loop_closures += loops.edges.size();
    statistics_.loops_refused += loops.refused;
    if (!loops.edges.empty() && optimise_after_loops()) nodes_have_moved(latest_node());
    outcome.loop_closures = static_cast<int>(loops.edges.size());
    outcome.matcher_errors.add(loops.errors, "loop");
  }

  /// Corrects the pose of the latest scan after a change of the graph.
  void nodes_have_moved(const SE2d& pose) {
    pose_ = pose;
    motion_model_.correct(pose_);
    tracker_.nodes_changed();
    joiner_.nodes_changed();
  }

  /// Where nodes are merged, only as far as the correction reaches: the time of a scan does not
  /// grow with the map.
  Result<void> optimise_after_loops() {
    constexpr int kIterations = 5;
    constexpr double kMinGain = 1e-4;
    return optimise(kIterations, kMinGain, local_optimiser_.around(nodes_.latest()));
  }

  /// To convergence; where nodes are merged, with the map as a whole where it is.
  Result<void> optimise_all() {
    constexpr int kIterations = 50;
    constexpr double kMinGain = 1e-6;
    if (!merges_nodes(options_, nodes_)) return optimise(kIterations, kMinGain, optimiser_);
    return optimise(kIterations, kMinGain, local_optimiser_.everywhere());
  }

  template <class Optimiser>
  Result<void> optimise(int iterations, double min_gain, Optimiser& optimiser) {
    return wayfare::optimise(optimiser, nodes_.graph(), loop_kernel(options_.loop_kernel_sigmas),
                             iterations, min_gain, statistics_.optimisations);
  }

  void count(const ScanOutcome& outcome) {
    const bool first = statistics_.scans++ == 0;
    statistics_.unmatched_scans += outcome.matched || first ? 0 : 1;
    statistics_.matcher_errors.add(outcome.matcher_errors);
    joiner_.count(nodes_, statistics_);
  }

  [[nodiscard]] const SE2d& latest_node() const { return nodes_.pose(nodes_.latest()); }

  GraphSlamOptions options_;
  CallGuard guard_;
  MotionModel motion_model_;
  Tracker<Matching> tracker_;
  LoopCloser<Matching> loop_closer_;
  PieceJoiner<Matching> joiner_;
  PoseGraphOptimiser<SE2d> optimiser_;
  LocalOptimiser local_optimiser_;
  NodeMerger merger_;

  NodeMap nodes_;
  std::vector<ScanPose> scans_;
  LossDetector loss_;
  SE2d pose_;                                             // of the latest scan
  Eigen::Matrix3d since_node_ = Eigen::Matrix3d::Zero();  // covariance of the motion since the node
  GraphSlamStatistics statistics_;
};

}  // namespace wayfare::detail
