#include <wayfare/slam/graph_slam.hpp>

#include <cmath>
#include <utility>
#include <vector>

#include <Eigen/LU>

#include <wayfare/slam/detail/loops.hpp>
#include <wayfare/slam/detail/motion.hpp>
#include <wayfare/slam/detail/scans.hpp>

#include "slam/graph_slam/loop_closer.hpp"
#include "slam/graph_slam/node_map.hpp"
#include "slam/graph_slam/tracker.hpp"

namespace wayfare {

class GraphSlam::Engine {
 public:
  explicit Engine(const GraphSlamOptions& options)
      : options_(with_valid_counts(options)),
        motion_model_(options.odometry, options.constant_velocity),
        tracker_(options_),
        loop_closer_(options_) {}

  Result<ScanOutcome> add_scan(const LaserScan& scan, const std::optional<SE2d>& odometry) {
    if (auto ok = detail::check_scan(scan, odometry, scans_); !ok) return ok.error();
    const PointSet points = points_of(scan);
    ScanOutcome outcome = nodes_.size() == 0
                              ? begin(points, odometry)
                              : track_scan(points, motion_model_.predict(scan.time, odometry));
    motion_model_.update(scan.time, pose_, odometry);
    if (outcome.became_node) outcome.loop_closures = close_loops();
    outcome.T_map_base = MapPose(pose_);
    scans_.push_back({scan.time, nodes_.latest(), latest_node().inverse() * pose_});
    count(outcome);
    return outcome;
  }

  Result<void> finish() {
    if (nodes_.size() < 2) return {};
    if (auto done = optimise(50, 1e-6); !done) return done;
    nodes_have_moved(latest_node() * scans_.back().T_node_base);
    return {};
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
      // A scan too large for the raster is left out of the map.
      (void)insert_points(grid, nodes_.pose(k), nodes_.points(k), model, raster, laser);
    }
    return grid;
  }

  [[nodiscard]] const PoseGraph2& graph() const { return nodes_.graph(); }
  [[nodiscard]] const GraphSlamStatistics& statistics() const { return statistics_; }

 private:
  static GraphSlamOptions with_valid_counts(GraphSlamOptions o) {
    detail::limit_counts({&o.local_nodes, &o.sharp_nodes, &o.nodes_between_loops, &o.loop_gap_nodes,
                          &o.loop_context_nodes, &o.loop_map_nodes, &o.loops_per_search});
    return o;
  }

  [[nodiscard]] PointSet points_of(const LaserScan& scan) const {
    return thin(end_points(scan, options_.T_base_laser.raw()),
                static_cast<float>(options_.point_spacing_m),
                static_cast<float>(options_.max_range_m));
  }

  /// The first scan is the first node, at the odometry pose.
  ScanOutcome begin(const PointSet& points, const std::optional<SE2d>& odometry) {
    pose_ = odometry.value_or(SE2d());
    nodes_.start(pose_, points);
    ScanOutcome outcome;
    outcome.became_node = true;
    return outcome;
  }

  /// Tracks the scan; adds a node if one is due.
  ScanOutcome track_scan(const PointSet& points, const Motion& motion) {
    const auto [match, widened] = tracker_.place(nodes_, points, pose_ * motion.increment, motion);
    pose_ = match.T_map_points;
    since_node_ = motion.accumulated(since_node_);
    ScanOutcome outcome;
    outcome.score = match.score;
    outcome.matched = match.score >= options_.lost_score;
    const SE2d step = latest_node().inverse() * pose_;
    const double travel_m = step.translation().norm();
    const double turn_rad = std::abs(step.heading().radians());
    outcome.became_node =
        travel_m > options_.node_distance_m || turn_rad > options_.node_turn.radians();
    if (outcome.became_node) {
      nodes_.append(pose_, points, information(match, travel_m, turn_rad));
      since_node_.setZero();
      tracker_.nodes_changed();
    }
    statistics_.widened_searches += widened ? 1 : 0;
    return outcome;
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

  int close_loops() {
    const Loops loops = loop_closer_.search(nodes_);
    auto& edges = nodes_.graph().edges;
    edges.insert(edges.end(), loops.edges.begin(), loops.edges.end());
    statistics_.loop_closures += loops.edges.size();
    statistics_.loops_refused += loops.refused;
    if (!loops.edges.empty() && optimise(5, 1e-4)) nodes_have_moved(latest_node());
    return static_cast<int>(loops.edges.size());
  }

  /// Corrects the pose of the latest scan after a change of the graph.
  void nodes_have_moved(const SE2d& pose) {
    pose_ = pose;
    motion_model_.correct(pose_);
    tracker_.nodes_changed();
  }

  Result<void> optimise(int iterations, double min_gain) {
    return wayfare::optimise(optimiser_, nodes_.graph(), loop_kernel(options_.loop_kernel_sigmas),
                             iterations, min_gain, statistics_.optimisations);
  }

  void count(const ScanOutcome& outcome) {
    const bool first = statistics_.scans++ == 0;
    statistics_.unmatched_scans += outcome.matched || first ? 0 : 1;
  }

  [[nodiscard]] const SE2d& latest_node() const { return nodes_.pose(nodes_.latest()); }

  GraphSlamOptions options_;
  MotionModel motion_model_;
  Tracker tracker_;
  LoopCloser loop_closer_;
  PoseGraphOptimiser<SE2d> optimiser_;

  NodeMap nodes_;
  std::vector<ScanPose> scans_;
  SE2d pose_;                                             // of the latest scan
  Eigen::Matrix3d since_node_ = Eigen::Matrix3d::Zero();  // covariance of the motion since the node
  GraphSlamStatistics statistics_;
};

GraphSlam::GraphSlam(const GraphSlamOptions& options)
    : engine_(detail::make_owned<Engine>(options)) {}

Result<ScanOutcome> GraphSlam::add_scan(const LaserScan& scan,
                                        const std::optional<OdomPose>& odometry) {
  return engine_->add_scan(scan, detail::raw(odometry));
}
Result<void> GraphSlam::finish() { return engine_->finish(); }
Trajectory GraphSlam::trajectory() const { return engine_->trajectory(); }
const PoseGraph2& GraphSlam::graph() const { return engine_->graph(); }
const GraphSlamStatistics& GraphSlam::statistics() const { return engine_->statistics(); }
OccupancyGrid GraphSlam::map(const OccupancyGridOptions& shape,
                             const InverseLidarModel& model) const {
  return engine_->map(shape, model);
}

Result<GraphSlamRun> run_graph_slam(const Recording& recording, GraphSlamOptions options,
                                    const SlamProgress& progress) {
  options.T_base_laser = recording.T_base_laser;
  GraphSlam slam(options);
  const OdometryTrack odometry(recording.odometry);
  auto refused = detail::feed_scans(recording, progress, slam.statistics(), [&](std::size_t i) {
    return slam.add_scan(recording.scans[i], odometry.at(recording.scans[i].time));
  });
  if (!refused) return refused.error();
  if (auto ok = slam.finish(); !ok) return ok.error();
  return GraphSlamRun{slam.trajectory(), slam.graph(),   slam.map(),
                      slam.statistics(), refused->count, std::move(refused->first)};
}

}  // namespace wayfare
