#include <wayfare/slam/graph_slam.hpp>

#include <cmath>
#include <utility>
#include <vector>

#include <wayfare/graph/optimise.hpp>

#include "slam/graph_slam/loop_closer.hpp"
#include "slam/graph_slam/node_maker.hpp"
#include "slam/graph_slam/node_map.hpp"
#include "slam/graph_slam/tracker.hpp"
#include "slam/motion.hpp"
#include "slam/scan_check.hpp"

namespace wayfare {
namespace {

/// A scan's pose relative to its node.
struct ScanPose {
  LogTime time;
  int node;
  SE2d T_node_base;
};

}  // namespace

class GraphSlam::Engine {
 public:
  explicit Engine(const GraphSlamOptions& options)
      : options_(options),
        motion_model_(options.odometry, options.constant_velocity),
        tracker_(options),
        node_maker_(options),
        loop_closer_(options) {}

  Result<ScanOutcome> add_scan(const LaserScan& scan, const std::optional<SE2d>& odometry) {
    const auto last = scans_.empty() ? std::nullopt : std::optional(scans_.back().time);
    if (auto ok = detail::check_scan(scan, odometry, last); !ok) return ok.error();
    const PointSet points = points_of(scan);
    ScanOutcome outcome = nodes_.size() == 0
                              ? begin(points, odometry)
                              : track_scan(points, motion_model_.predict(scan.time, odometry));
    motion_model_.update(scan.time, pose_, odometry);
    if (outcome.became_node) outcome.loop_closures = close_loops();
    outcome.T_map_base = Transform2<frame::Map, frame::Base>(pose_);
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
    for (const ScanPose& s : scans_) {
      const SE2d T_map_base = nodes_.pose(s.node) * s.T_node_base;
      result.push_back({s.time, Transform2<frame::Map, frame::Base>(T_map_base)});
    }
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
    node_maker_.accumulate(motion);
    ScanOutcome outcome;
    outcome.score = match.score;
    outcome.matched = match.score >= options_.lost_score;
    outcome.became_node = node_maker_.is_due(nodes_, pose_);
    if (outcome.became_node) {
      node_maker_.add(nodes_, pose_, points, match);
      tracker_.nodes_changed();
    }
    statistics_.widened_searches += widened ? 1 : 0;
    return outcome;
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
    OptimiseOptions options;
    options.kernel = loop_closer_.kernel();
    options.max_iterations = iterations;
    options.min_relative_gain = min_gain;
    const auto report = optimiser_.optimise(nodes_.graph(), options);
    if (!report) return report.error();
    ++statistics_.optimisations;
    return {};
  }

  void count(const ScanOutcome& outcome) {
    const bool first = statistics_.scans++ == 0;
    statistics_.unmatched_scans += outcome.matched || first ? 0 : 1;
  }

  [[nodiscard]] const SE2d& latest_node() const { return nodes_.pose(nodes_.latest()); }

  GraphSlamOptions options_;
  MotionModel motion_model_;
  Tracker tracker_;
  NodeMaker node_maker_;
  LoopCloser loop_closer_;
  PoseGraphOptimiser<SE2d> optimiser_;

  NodeMap nodes_;
  std::vector<ScanPose> scans_;
  SE2d pose_;  // of the latest scan
  GraphSlamStatistics statistics_;
};

GraphSlam::GraphSlam(const GraphSlamOptions& options)
    : engine_(std::make_unique<Engine>(options)) {}
GraphSlam::~GraphSlam() = default;
GraphSlam::GraphSlam(GraphSlam&&) noexcept = default;
GraphSlam& GraphSlam::operator=(GraphSlam&&) noexcept = default;

Result<ScanOutcome> GraphSlam::add_scan(
    const LaserScan& scan, const std::optional<Transform2<frame::Odom, frame::Base>>& odometry) {
  return engine_->add_scan(scan, odometry ? std::optional(odometry->raw()) : std::nullopt);
}
Result<void> GraphSlam::finish() { return engine_->finish(); }
Trajectory GraphSlam::trajectory() const { return engine_->trajectory(); }
const PoseGraph2& GraphSlam::graph() const { return engine_->graph(); }
const GraphSlamStatistics& GraphSlam::statistics() const { return engine_->statistics(); }
OccupancyGrid GraphSlam::map(const OccupancyGridOptions& shape,
                             const InverseLidarModel& model) const {
  return engine_->map(shape, model);
}

}  // namespace wayfare
