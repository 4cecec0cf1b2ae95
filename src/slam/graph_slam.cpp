#include <wayfare/system/graph_slam.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <unordered_set>
#include <utility>
#include <vector>

#include <Eigen/Eigenvalues>

#include <wayfare/graph/optimise.hpp>
#include <wayfare/graph/path_uncertainty.hpp>
#include <wayfare/sync/odometry_track.hpp>

#include "local_map.hpp"
#include "parallel_for.hpp"

namespace wayfare {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr std::size_t kMinPoints = 10;

/// A motion and how far it may be off, in the frame of where it ends.
struct Motion {
  SE2d increment;
  Vector3d sigma = Vector3d::Zero();  // m, m, rad

  [[nodiscard]] Matrix3d covariance() const { return sigma.cwiseAbs2().asDiagonal(); }
};

Vector3d sigma_of(const SE2d& increment, const MotionNoise& noise) {
  const double d = increment.translation().norm();
  const double turn = std::abs(increment.heading().radians());
  const double along =
      noise.translation_floor_m + noise.translation_per_m * d + noise.translation_per_rad_m * turn;
  const double heading =
      noise.heading_floor.radians() + noise.heading_per_rad * turn + noise.heading_per_m_rad * d;
  return {along, along, heading};
}

struct Node {
  PointSet points;      // base frame
  double travel_m = 0;  // from the first node, along the nodes
};

/// Where a scan was, relative to the node it hangs on.
struct ScanPose {
  LogTime time;
  int node;
  SE2d T_node_base;
};

struct LoopCandidate {
  int node;
  Matrix3d covariance;  // of the latest node relative to it
};

struct LoopMatch {
  bool accepted = false;
  PoseEdge<SE2d> edge;
};

/// How far a match may be off in each direction of its spread: σ grows with the cube of the
/// spread, from nothing in a room (1-3) to decimetres in a corridor without doors (7-13), where the
/// few gradients along the walls come from cells and noise.
struct Ambiguity {
  Eigen::Matrix2d directions;  // columns, map axes
  Eigen::Vector2d variance;    // m²

  explicit Ambiguity(const Placement& match) {
    constexpr double kSigmaPerCubedSpread_m = 0.0004;
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> eigen(match.spread);
    directions = eigen.eigenvectors();
    variance = (kSigmaPerCubedSpread_m * eigen.eigenvalues().array().cube()).square();
  }
};

/// The match moved towards what the motion model predicted, along the directions in which the scene
/// leaves it open: x = x_match + Σ_match (Σ_match + Σ_motion)⁻¹ (x_motion − x_match).
SE2d settle(const Placement& match, const SE2d& predicted, const Motion& motion) {
  const Ambiguity open(match);
  const double motion_variance = motion.sigma[0] * motion.sigma[0];
  const Eigen::Vector2d gain =
      open.variance.cwiseQuotient(open.variance + Eigen::Vector2d::Constant(motion_variance));
  const Eigen::Vector2d gap = predicted.translation() - match.T_map_points.translation();
  const Eigen::Vector2d shift =
      open.directions * gain.asDiagonal() * open.directions.transpose() * gap;
  return SE2d(Eigen::Vector2d(match.T_map_points.translation() + shift),
              match.T_map_points.rotation());
}

/// Ω of an edge whose match is `sigma_m` and `sigma_rad` sure, and less where the scene leaves it
/// open; `rotation` leads from the edge's axes to the map's.
Matrix3d match_information(const Placement& match, const SO2d& rotation, double sigma_m,
                           double sigma_rad) {
  const Ambiguity open(match);
  const Eigen::Vector2d variance = open.variance + Eigen::Vector2d::Constant(sigma_m * sigma_m);
  const Eigen::Matrix2d axes = rotation.matrix().transpose() * open.directions;
  Matrix3d information = Matrix3d::Zero();
  information.topLeftCorner<2, 2>() =
      axes * variance.cwiseInverse().asDiagonal() * axes.transpose();
  information(2, 2) = 1.0 / (sigma_rad * sigma_rad);
  return information;
}

}  // namespace

class GraphSlam::Engine {
 public:
  explicit Engine(const GraphSlamOptions& options) : options_(options) {}

  Result<ScanOutcome> add_scan(const LaserScan& scan, const std::optional<SE2d>& odometry) {
    if (auto ok = check(scan, odometry); !ok) return ok.error();
    const PointSet points = thin(end_points(scan, options_.T_base_laser.raw()),
                                 static_cast<float>(options_.point_spacing_m),
                                 static_cast<float>(options_.max_range_m));
    ScanOutcome outcome;
    if (nodes_.empty()) {
      pose_ = odometry.value_or(SE2d());
      add_node(points, {});
      outcome.became_node = true;
    } else {
      const Motion motion = predict(scan.time, odometry);
      const Placement match = track(points, motion);
      outcome.score = match.score;
      outcome.matched = match.score >= options_.lost_score;
      move_to(match.T_map_points, motion);
      if (moved_enough()) {
        outcome.became_node = true;
        add_node(points, match);
        outcome.loop_closures = close_loops();
      }
    }
    remember(scan.time, odometry);
    outcome.T_map_base = Transform2<frame::Map, frame::Base>(pose_);
    ++statistics_.scans;
    statistics_.unmatched_scans += outcome.matched || statistics_.scans == 1 ? 0 : 1;
    return outcome;
  }

  Result<void> finish() { return nodes_.size() < 2 ? Result<void>() : optimise(50, 1e-6); }

  Trajectory trajectory() const {
    Trajectory result;
    result.reserve(scans_.size());
    for (const ScanPose& s : scans_) {
      result.push_back(
          {s.time, Transform2<frame::Map, frame::Base>(pose_of(s.node) * s.T_node_base)});
    }
    return result;
  }

  OccupancyGrid map(const OccupancyGridOptions& shape, const InverseLidarModel& model) const {
    OccupancyGrid grid(shape);
    ScanRaster raster;
    const Eigen::Vector2d laser = options_.T_base_laser.raw().translation();
    for (std::size_t k = 0; k < nodes_.size(); ++k) {
      // A scan too wide for the raster leaves the map as it is: the others still make one.
      (void)insert_points(grid, graph_.poses[k], nodes_[k].points, model, raster, laser);
    }
    return grid;
  }

  const PoseGraph2& graph() const { return graph_; }
  const GraphSlamStatistics& statistics() const { return statistics_; }

 private:
  // --- input ---------------------------------------------------------------------------------

  Result<void> check(const LaserScan& scan, const std::optional<SE2d>& odometry) const {
    if (scan.ranges_m.empty()) return Error{ErrorCode::invalid, "the scan has no beams"};
    if (!std::isfinite(scan.first_bearing.radians()) ||
        !std::isfinite(scan.bearing_step.radians())) {
      return Error{ErrorCode::invalid, "the scan's bearings are not finite"};
    }
    if (!scans_.empty() && scan.time < scans_.back().time) {
      return Error{ErrorCode::invalid, "the scan is earlier than the one before it"};
    }
    if (odometry &&
        !(odometry->translation().allFinite() && std::isfinite(odometry->heading().radians()))) {
      return Error{ErrorCode::invalid, "the odometry pose is not finite"};
    }
    return {};
  }

  void remember(LogTime time, const std::optional<SE2d>& odometry) {
    const SE2d T_node_base = graph_.poses.back().inverse() * pose_;
    if (!scans_.empty()) {
      const double dt = to_seconds(time - scans_.back().time);
      if (dt > 0.0) velocity_ = pose_.minus(last_pose_) / dt;
    }
    last_pose_ = pose_;
    last_odometry_ = odometry;
    scans_.push_back({time, static_cast<int>(nodes_.size()) - 1, T_node_base});
  }

  // --- motion --------------------------------------------------------------------------------

  /// Increments of odometry where both ends are known, else the velocity of the last two scans
  /// (held for at most half a second: nobody coasts through a gap in the log).
  Motion predict(LogTime time, const std::optional<SE2d>& odometry) const {
    if (odometry && last_odometry_) {
      const SE2d increment = last_odometry_->inverse() * *odometry;
      return {increment, sigma_of(increment, options_.odometry)};
    }
    const double dt = std::min(to_seconds(time - scans_.back().time), 0.5);
    const SE2d increment = SE2d::exp(velocity_ * dt);
    return {increment, sigma_of(increment, options_.constant_velocity)};
  }

  void move_to(const SE2d& pose, const Motion& motion) {
    const Matrix3d turn = motion.increment.inverse().adjoint();
    since_node_ = turn * since_node_ * turn.transpose() + motion.covariance();
    pose_ = pose;
  }

  [[nodiscard]] bool moved_enough() const {
    const SE2d moved = graph_.poses.back().inverse() * pose_;
    return moved.translation().norm() > options_.node_distance_m ||
           std::abs(moved.heading().radians()) > options_.node_turn.radians();
  }

  // --- tracking ------------------------------------------------------------------------------

  /// The scan's pose by the local map; the motion's own where nothing agrees.
  Placement track(const PointSet& points, const Motion& motion) {
    const SE2d prior = pose_ * motion.increment;
    if (points.size() < kMinPoints) return {prior};
    if (local_map_is_old_) render_local_maps();
    const Matrix3d information = motion.covariance().inverse();
    const Vector3d reach = (3.0 * motion.sigma).cwiseMin(0.5);
    Placement best = search_map_.search(
        points, prior, {reach[0], reach[1], Angle::radians(reach[2])}, information);
    if (best.score < options_.tracked_score) best = search_wider(points, prior, information, best);
    if (best.score < options_.lost_score) return {prior, best.score};
    const Placement sharp = sharp_map_.refine(points, best.T_map_points);
    return {settle(sharp, prior, motion), best.score, sharp.spread};
  }

  /// First farther around the prediction, then in every direction against all that is near.
  Placement search_wider(const PointSet& points, const SE2d& prior, const Matrix3d& information,
                         Placement best) {
    ++statistics_.widened_searches;
    const auto better = [&best](const Placement& other, double margin) {
      if (other.score > best.score + margin) best = other;
    };
    better(search_map_.search(points, prior, {0.8, 0.8, 50_deg}, 0.25 * information), 0.10);
    if (best.score >= options_.lost_score) return best;
    LocalMap around;
    around.render(nodes_around(prior, 4.0, 80), options_.cell_m, options_.search_sigma_m);
    const Matrix3d loose = Vector3d(0.5, 0.5, 1.0).cwiseAbs2().cwiseInverse().asDiagonal();
    better(around.search(points, prior, {1.0, 1.0, 180_deg}, loose), 0.30);
    return best;
  }

  void render_local_maps() {
    const int latest = static_cast<int>(nodes_.size()) - 1;
    search_map_.render(chain(latest - options_.local_nodes + 1, latest, latest), options_.cell_m,
                       options_.search_sigma_m);
    sharp_map_.render(chain(latest - options_.sharp_nodes + 1, latest, latest), options_.cell_m,
                      options_.sharp_sigma_m);
    local_map_is_old_ = false;
  }

  /// Nodes first..last that are within the local radius of `centre`.
  std::vector<PlacedPoints> chain(int first, int last, int centre) const {
    std::vector<PlacedPoints> placed;
    const int end = std::min(last, static_cast<int>(nodes_.size()) - 1);
    for (int k = std::max(first, 0); k <= end; ++k) {
      const double distance = (pose_of(k).translation() - pose_of(centre).translation()).norm();
      if (distance < options_.local_radius_m) placed.push_back({&node(k).points, pose_of(k)});
    }
    return placed;
  }

  /// The `most` nodes nearest to a place, within `radius_m`.
  std::vector<PlacedPoints> nodes_around(const SE2d& place, double radius_m,
                                         std::size_t most) const {
    std::vector<std::pair<double, int>> near;
    for (int k = 0; k < graph_.size(); ++k) {
      const double d = (pose_of(k).translation() - place.translation()).norm();
      if (d < radius_m) near.emplace_back(d, k);
    }
    std::sort(near.begin(), near.end());
    near.resize(std::min(near.size(), most));
    std::vector<PlacedPoints> placed;
    for (const auto& [d, k] : near) placed.push_back({&node(k).points, pose_of(k)});
    return placed;
  }

  // --- nodes ---------------------------------------------------------------------------------

  void add_node(const PointSet& points, const std::optional<Placement>& match) {
    const int index = graph_.add_pose(pose_);
    double travel = 0.0;
    if (index > 0) {
      const SE2d step = pose_of(index - 1).inverse() * pose_;
      travel = nodes_.back().travel_m + step.translation().norm();
      graph_.edges.push_back({index - 1, index, step, edge_information(step, *match), false});
    }
    nodes_.push_back({points, travel});
    since_node_.setZero();
    local_map_is_old_ = true;
  }

  /// What the match says, and along what it leaves open what odometry says.
  Matrix3d edge_information(const SE2d& step, const Placement& match) const {
    const double d = step.translation().norm();
    const double turn = std::abs(step.heading().radians());
    if (match.score < options_.lost_score) {
      const double sigma = 0.1 + 0.3 * d, sigma_rad = Angle::degrees(10).radians() + 0.5 * turn;
      return Vector3d(sigma, sigma, sigma_rad).cwiseAbs2().cwiseInverse().asDiagonal();
    }
    const Matrix3d by_match = match_information(match, pose_.rotation(), 0.02 + 0.02 * d,
                                                Angle::degrees(0.4).radians() + 0.02 * turn);
    return by_match + since_node_.inverse();
  }

  // --- loops ---------------------------------------------------------------------------------

  int close_loops() {
    const int latest = graph_.size() - 1;
    if (latest - last_loop_search_ < options_.nodes_between_loops) return 0;
    last_loop_search_ = latest;
    const std::vector<LoopCandidate> candidates = loop_candidates(latest);
    if (candidates.empty()) return 0;
    const PointSet context = loop_context(latest);
    std::vector<LoopMatch> matches(candidates.size());
    parallel_for(candidates.size(), options_.threads,
                 [&](std::size_t i) { matches[i] = match_loop(candidates[i], latest, context); });
    int found = 0;
    for (const LoopMatch& match : matches) {
      if (!match.accepted) continue;
      graph_.edges.push_back(match.edge);
      ++found;
    }
    statistics_.loop_closures += static_cast<std::size_t>(found);
    statistics_.loops_refused += matches.size() - static_cast<std::size_t>(found);
    if (found == 0 || !optimise(5, 1e-4)) return found;
    pose_ = graph_.poses.back();
    local_map_is_old_ = true;
    return found;
  }

  /// One node for every stretch of the trajectory that may share a view with the latest node: the
  /// nearest of the stretch.
  std::vector<LoopCandidate> loop_candidates(int latest) const {
    const PathUncertainty known = path_uncertainty(
        graph_, latest, [&](const PoseEdge<SE2d>& e) { return !e.robust || believed(e); });
    const double travel = node(latest).travel_m;
    std::vector<LoopCandidate> result;
    double nearest = std::numeric_limits<double>::infinity();
    int gap = 2;  // nodes since the last that qualified; a single miss does not end a stretch
    for (int k = 0; k < latest - options_.loop_gap_nodes; ++k) {
      const double distance = (pose_of(k).translation() - pose_of(latest).translation()).norm();
      const auto& covariance = known.covariance[static_cast<std::size_t>(k)];
      const double reach = 3.0 * std::sqrt(std::max(covariance(0, 0), covariance(1, 1)));
      if (!known.reached(k) || travel - node(k).travel_m <= options_.loop_gap_travel_m ||
          distance - std::min(reach, options_.loop_reach_m) >= options_.loop_overlap_m) {
        ++gap;
        continue;
      }
      if (gap >= 2) {
        if (static_cast<int>(result.size()) == options_.loops_per_search) break;
        result.push_back({k, covariance});
        nearest = distance;
      } else if (distance < nearest) {
        result.back() = {k, covariance};
        nearest = distance;
      }
      gap = 0;
    }
    return result;
  }

  [[nodiscard]] bool believed(const PoseEdge<SE2d>& edge) const {
    return kernel()(squared_error(graph_, edge)).weight > 0.3;
  }
  [[nodiscard]] RobustKernel kernel() const {
    return {RobustKernelKind::cauchy, options_.loop_kernel_sigmas};
  }

  /// The latest nodes' points together, in the latest node's frame, one a 10 cm cell: a wider and
  /// less ambiguous view than a single scan.
  PointSet loop_context(int latest) const {
    constexpr double kCell_m = 0.1;
    PointSet context;
    std::unordered_set<std::int64_t> taken;
    for (int k = latest; k >= std::max(0, latest - options_.loop_context_nodes); --k) {
      const SE2d T_latest_node = pose_of(latest).inverse() * pose_of(k);
      const PointSet& points = node(k).points;
      for (std::size_t i = 0; i < points.size(); ++i) {
        const Eigen::Vector2d p = T_latest_node * points[i].cast<double>();
        const auto x = static_cast<std::int64_t>(std::floor(p.x() / kCell_m));
        const auto y = static_cast<std::int64_t>(std::floor(p.y() / kCell_m));
        if (taken.insert((x << 32) ^ (y & 0xffffffff)).second) context.push_back(p.cast<float>());
      }
    }
    return context;
  }

  LoopMatch match_loop(const LoopCandidate& candidate, int latest, const PointSet& context) const {
    const std::vector<PlacedPoints> around = chain_without_radius(
        candidate.node - options_.loop_map_nodes,
        std::min(candidate.node + options_.loop_map_nodes, latest - options_.loop_gap_nodes + 5));
    const Matrix3d& c = candidate.covariance;
    const double reach =
        std::clamp(3.0 * std::sqrt(std::max(c(0, 0), c(1, 1))), 0.3, options_.loop_reach_m);
    const Angle turn = Angle::radians(std::clamp(
        3.0 * std::sqrt(c(2, 2)), Angle::degrees(4).radians(), Angle::degrees(90).radians()));
    const SE2d prior = pose_of(latest);
    LocalMap map;
    map.render(around, options_.cell_m, options_.search_sigma_m);
    const double needed = reach > 1.0 ? options_.wide_loop_score : options_.loop_score;
    const Placement found = reach > 0.6
                                ? map.search_far(context, prior, {reach, reach, turn}, needed)
                                : map.search(context, prior, {reach, reach, turn});
    if (found.score < needed) return {};
    LocalMap sharp_map;
    sharp_map.render(around, options_.cell_m, options_.sharp_sigma_m);
    const Placement sharp = sharp_map.refine(node(latest).points, found.T_map_points);
    const SE2d measurement = pose_of(candidate.node).inverse() * sharp.T_map_points;
    const Matrix3d information = match_information(sharp, sharp.T_map_points.rotation(), 0.04,
                                                   Angle::degrees(0.6).radians());
    return {true, {candidate.node, latest, measurement, information, true}};
  }

  std::vector<PlacedPoints> chain_without_radius(int first, int last) const {
    std::vector<PlacedPoints> placed;
    for (int k = std::max(first, 0); k <= last; ++k)
      placed.push_back({&node(k).points, pose_of(k)});
    return placed;
  }

  Result<void> optimise(int iterations, double min_gain) {
    OptimiseOptions options;
    options.kernel = kernel();
    options.max_iterations = iterations;
    options.min_relative_gain = min_gain;
    const auto report = optimiser_.optimise(graph_, options);
    if (!report) return report.error();
    ++statistics_.optimisations;
    return {};
  }

  [[nodiscard]] const Node& node(int k) const { return nodes_[static_cast<std::size_t>(k)]; }
  [[nodiscard]] const SE2d& pose_of(int k) const {
    return graph_.poses[static_cast<std::size_t>(k)];
  }

  GraphSlamOptions options_;
  std::vector<Node> nodes_;
  PoseGraph2 graph_;
  std::vector<ScanPose> scans_;
  PoseGraphOptimiser<SE2d> optimiser_;
  LocalMap search_map_, sharp_map_;
  bool local_map_is_old_ = true;

  SE2d pose_, last_pose_;                 // of the latest scan, of the one before it
  Vector3d velocity_ = Vector3d::Zero();  // body frame, per second
  std::optional<SE2d> last_odometry_;
  Matrix3d since_node_ = Matrix3d::Zero();  // odometry's covariance since the latest node
  int last_loop_search_ = 0;
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

Result<GraphSlamRun> run_graph_slam(const Recording& recording, GraphSlamOptions options,
                                    const SlamProgress& progress) {
  options.T_base_laser = recording.T_base_laser;
  GraphSlam slam(options);
  const OdometryTrack odometry(recording.odometry);
  std::size_t refused = 0;
  std::string first_refusal;
  for (std::size_t i = 0; i < recording.scans.size(); ++i) {
    const LaserScan& scan = recording.scans[i];
    const auto outcome = slam.add_scan(scan, odometry.at(scan.time));
    if (!outcome && refused++ == 0) {
      first_refusal = "scan " + std::to_string(i) + ": " + outcome.error().message;
    }
    const double done = static_cast<double>(i + 1) / static_cast<double>(recording.scans.size());
    if (progress && !progress(done)) break;
  }
  if (slam.statistics().scans == 0) {
    return Error{ErrorCode::invalid, recording.scans.empty()
                                         ? "the recording has no scans"
                                         : "no scan could be used; " + first_refusal};
  }
  if (auto ok = slam.finish(); !ok) return ok.error();
  return GraphSlamRun{slam.trajectory(), slam.graph(), slam.map(),
                      slam.statistics(), refused,      first_refusal};
}

}  // namespace wayfare
