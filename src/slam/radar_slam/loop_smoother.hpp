#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <optional>
#include <utility>
#include <vector>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>

#include <wayfare/graph/optimise.hpp>
#include <wayfare/graph/path_uncertainty.hpp>
#include <wayfare/match/pose_proposal.hpp>
#include <wayfare/slam/detail/loops.hpp>

#include "slam/radar_slam/mapped_scan.hpp"

namespace wayfare {

/// Closes loops of the best particle's path. With few particles all share one history long before
/// the robot returns, so that none of them closes the loop, or only at its end. Here the latest
/// scans are matched to a map of the earlier visit alone, over the whole uncertainty of the path
/// since; nodes of the path and these matches are a pose graph, which distributes the error over
/// the loop.
class LoopSmoother {
 public:
  explicit LoopSmoother(const RadarSlamOptions& options) : options_(options), maker_(options_) {}

  /// In order; `pose` is the best particle's.
  void add(MappedScan scan, const SE2d& pose) {
    uses_[scan.sensor] = true;
    const double step_m = nodes_.empty() ? 0.0 : (pose.translation() - nodes_.back().at_m).norm();
    if (nodes_.empty() || step_m >= loop().node_distance_m)
      nodes_.push_back({scan.update, pose.translation(),
                        nodes_.empty() ? 0.0 : nodes_.back().travel_m + step_m, scans_.size()});
    scans_.push_back(std::move(scan));
  }

  /// The path smoothed, if the latest node closes a loop that moves it. One pose per update.
  [[nodiscard]] std::optional<Trajectory> smooth(const Trajectory& path) {
    if (!is_due()) return std::nullopt;
    searched_ = nodes_.size();
    graph_ = graph_of(path);
    if (!find_loops(path)) return std::nullopt;
    graph_ = graph_of(path);
    const std::vector<SE2d> before = graph_.poses;
    OptimiseOptions options;
    options.kernel = loop_kernel(loop().kernel_sigmas);
    options.max_iterations = 30;
    if (!optimiser_.optimise(graph_, options)) return std::nullopt;
    if (!moves(before.back(), graph_.poses.back())) return std::nullopt;
    smoothed_ = nodes_.size();
    odometry_.assign(graph_.edges.begin(), graph_.edges.end() - std::ssize(loops_));
    for (std::size_t k = 0; k < nodes_.size(); ++k) nodes_[k].at_m = graph_.poses[k].translation();
    return moved(path, before);
  }

  /// Of the path's last pose relative to its first, by the drift and the loops.
  [[nodiscard]] Eigen::Matrix3d covariance(const Trajectory& path) const {
    if (nodes_.empty()) return Eigen::Matrix3d::Zero();
    PoseGraph2 graph = graph_of(path);
    for (std::size_t k = 0; k + 1 < nodes_.size(); ++k)
      graph.edges[k].information *= better().drift_margin * better().drift_margin;
    const SE2d since = graph.poses.back().inverse() * path.back().T_map_base.raw();
    Gaussian<SE2d> last{SE2d(), drift(nodes_.back().travel_m)};
    PoseGraphOptimiser<SE2d> optimiser;
    if (optimiser.prepare_covariances(graph, loop_kernel(loop().kernel_sigmas)))
      last.covariance = optimiser.relative_covariance(graph, 0, graph.size() - 1);
    return compose(last, Gaussian<SE2d>{since, drift(since.translation().norm())}).covariance;
  }

  /// Of all scans, with their updates' poses.
  [[nodiscard]] RbpfMaps maps(const Trajectory& path, RbpfMaps blank) {
    for (const MappedScan& scan : scans_)
      maker_.insert(blank, path[scan.update + 1].T_map_base.raw(), scan);
    return blank;
  }

 private:
  struct Node {
    std::size_t update;
    Eigen::Vector2d at_m;
    double travel_m;    // along the path
    std::size_t scans;  // added before it
  };
  using Edge = PoseEdge<SE2d>;

  [[nodiscard]] const LoopSmoothingOptions& loop() const { return options_.loops; }
  [[nodiscard]] const RbpfSensorOptions& of(Sensor sensor) const {
    return sensor == kLidar ? options_.lidar : options_.radar;
  }
  /// The more accurate sensor, whose drift is the path's.
  [[nodiscard]] const RbpfSensorOptions& better() const {
    return uses_[kLidar] ? options_.lidar : options_.radar;
  }
  /// Of a stretch of the path, and the same with the margin of the search.
  [[nodiscard]] Eigen::Matrix3d drift(double travel_m) const {
    return better().drift.covariance(travel_m);
  }
  [[nodiscard]] Eigen::Matrix3d likely(double travel_m) const {
    return better().drift_margin * better().drift_margin * drift(travel_m);
  }
  [[nodiscard]] bool is_earlier(const Node& node) const {
    return nodes_.back().travel_m - node.travel_m >= loop().gap_m;
  }

  /// Whether an earlier visit's node is within the largest reach.
  [[nodiscard]] bool is_due() const {
    if (!(loop().gap_m > 0.0) || nodes_.size() < searched_ + loop().nodes_between) return false;
    return std::ranges::any_of(nodes_, [&](const Node& node) {
      return is_earlier(node) && (node.at_m - nodes_.back().at_m).norm() < loop().largest_reach_m;
    });
  }

  /// Nodes at their poses in the path; steps since the last smoothing are measured by it. Edges: of
  /// the steps, then the loops.
  [[nodiscard]] PoseGraph2 graph_of(const Trajectory& path) const {
    PoseGraph2 graph;
    for (const Node& node : nodes_) graph.poses.push_back(path[node.update + 1].T_map_base.raw());
    graph.edges = odometry_;
    graph.edges.resize(nodes_.size() - 1);
    for (std::size_t k = std::max<std::size_t>(smoothed_, 1); k < nodes_.size(); ++k) {
      const double step_m = nodes_[k].travel_m - nodes_[k - 1].travel_m;
      graph.edges[k - 1] = {static_cast<int>(k - 1), static_cast<int>(k),
                            graph.poses[k - 1].inverse() * graph.poses[k], likely(step_m).inverse(),
                            false};
    }
    graph.edges.insert(graph.edges.end(), loops_.begin(), loops_.end());
    return graph;
  }
  /// Matches the latest scans of each sensor to those of the nearest earlier visit.
  [[nodiscard]] bool find_loops(const Trajectory& path) {
    const int latest = graph_.size() - 1;
    const PathUncertainty known =
        path_uncertainty(graph_, latest, [](const Edge&) { return true; });
    int nearest = -1;
    double nearest_m = loop().largest_reach_m;
    for (int k = 0; k < latest && is_earlier(node(k)); ++k) {
      // Where the earlier visit begins its map ends, and points beyond the end move scans onto it.
      if (node(k).travel_m < loop().context_m) continue;
      const double away_m =
          (graph_.poses[at(k)].translation() - graph_.poses[at(latest)].translation()).norm();
      if (!known.reached(k) || away_m >= nearest_m ||
          away_m - reach_m(known.covariance[at(k)]) >= loop().overlap_m)
        continue;
      nearest = k;
      nearest_m = away_m;
    }
    if (nearest < 0) return false;
    // That of the latest node relative to the earlier one, in the latest's axes.
    const SE2d back = graph_.poses[at(latest)].inverse() * graph_.poses[at(nearest)];
    const Eigen::Matrix3d adjoint = back.adjoint();
    Gaussian<SE2d> expected{graph_.poses[at(latest)],
                            adjoint * known.covariance[at(nearest)] * adjoint.transpose()};
    std::vector<Edge> found;
    for (const Sensor sensor : {kLidar, kRadar}) {
      const auto match = uses_[sensor] ? this->match(path, sensor, expected) : std::nullopt;
      if (!match) continue;
      const Edge edge{nearest, latest, graph_.poses[at(nearest)].inverse() * match->mean,
                      match->covariance.inverse(), true};
      const auto before = std::exchange(before_[sensor], edge);
      if (before && agree(*before, edge)) found.push_back(edge);
    }
    if (found.empty() || (found.size() == 2 && !agree(found[0], found[1]))) return false;
    loops_.insert(loops_.end(), found.begin(), found.end());
    return true;
  }
  static std::size_t at(int k) { return static_cast<std::size_t>(k); }
  [[nodiscard]] const Node& node(int k) const { return nodes_[at(k)]; }

  /// Whether two matches give one pose of the later's node, the path between considered.
  [[nodiscard]] bool agree(const Edge& a, const Edge& b) const {
    const auto placed = [&](const Edge& e) { return graph_.poses[at(e.from)] * e.measurement; };
    const SE2d between = graph_.poses[at(a.to)].inverse() * graph_.poses[at(b.to)];
    const double travel_m = node(b.to).travel_m - node(a.to).travel_m;
    const Gaussian<SE2d> by_a = compose(Gaussian<SE2d>{placed(a), a.information.inverse()},
                                        Gaussian<SE2d>{between, likely(std::max(travel_m, 1e-3))});
    const Eigen::Matrix3d covariance = by_a.covariance + b.information.inverse();
    const double sigmas = loop().agreement_sigmas;
    return squared_mahalanobis(Gaussian<SE2d>{by_a.mean, covariance}, placed(b)) < sigmas * sigmas;
  }

  /// Pose of the latest node by the moments of the likelihood, over a prior wide enough not to
  /// count twice.
  [[nodiscard]] std::optional<Gaussian<SE2d>> match(const Trajectory& path, Sensor sensor,
                                                    const Gaussian<SE2d>& expected) {
    const RbpfSensorOptions& o = of(sensor);
    const PointSet points = every_kth(latest_points(path, sensor), loop().points);
    if (points.size() < o.min_points) return std::nullopt;
    RbpfMaps maps{OccupancyGrid(options_.lidar.grid), OccupancyGrid(coarse())};
    insert_earlier(path, sensor, expected.mean, maps);
    const OccupancyGrid& grid = sensor == kLidar ? maps.lidar : maps.radar;
    Gaussian<SE2d> prior = expected;
    const double floor_m = 2.0 * grid.resolution_m();
    prior.covariance *= loop().prior_scale * loop().prior_scale;
    prior.covariance.diagonal() += Eigen::Vector3d(floor_m, floor_m, 0.02).cwiseAbs2();
    const FieldReach reach{PoseProposal::kMaxHalf * grid.resolution_m(),
                           3.0 * std::sqrt(prior.covariance(2, 2))};
    const auto made =
        o.density ? densities_.make(grid, points, prior.mean, reach, coarse_density(o), view_)
                  : fields_.make(grid, points, prior.mean, reach, o.field, view_);
    if (!made) return std::nullopt;
    PoseProposalOptions options{.samples = 4000,
                                .headings = 60,
                                .reach_sigmas = 3.0,
                                .independent_points = o.independent_points,
                                .divide_by_proposal = true};
    Rng rng = Rng(options_.seed).stream(nodes_.size());
    Gaussian<SE2d> proposal = prior;
    for (int pass = 0; pass < 2; ++pass) {
      const auto drawn = proposal_.draw(view_, points, proposal, prior, rng, options);
      if (!drawn) return std::nullopt;
      proposal = drawn->moments;
      const double floor = pass == 0 ? 0.5 * grid.resolution_m() : o.loop_sigma_m;
      proposal.covariance.diagonal() +=
          Eigen::Vector3d(floor, floor, pass == 0 ? 0.003 : o.loop_sigma_turn.radians())
              .cwiseAbs2();
    }
    // One farther away is chance: the scans show nothing of the earlier visit yet.
    const Gaussian<SE2d> wide{expected.mean, expected.covariance + proposal.covariance};
    const double sigmas = loop().agreement_sigmas;
    if (score(points, proposal.mean) < o.loop_score ||
        squared_mahalanobis(wide, proposal.mean) > sigmas * sigmas)
      return std::nullopt;
    return proposal;
  }

  /// Of a map of detections for a search of metres.
  [[nodiscard]] OccupancyGridOptions coarse() const {
    OccupancyGridOptions grid = options_.radar.grid;
    grid.resolution_m *= 2.0;
    return grid;
  }
  [[nodiscard]] static DetectionViewOptions coarse_density(const RbpfSensorOptions& o) {
    DetectionViewOptions density = *o.density;
    density.blur_sigma_m *= 2.0;
    return density;
  }

  /// Mean agreement of the points, [0, 1].
  [[nodiscard]] double score(const PointSet& points, const SE2d& pose) const {
    double sum = 0.0;
    for (std::size_t i = 0; i < points.size(); ++i)
      sum += view_.log_likelihood(
          cell_of(pose * Eigen::Vector2d(points[i].cast<double>()), view_.resolution_m()));
    return 1.0 - sum / (static_cast<double>(points.size()) * view_.log_floor());
  }

  /// Of the stretch before the latest node, in its frame.
  [[nodiscard]] PointSet latest_points(const Trajectory& path, Sensor sensor) const {
    const SE2d latest = graph_.poses.back();
    std::size_t first = nodes_.size() - 1;
    while (first > 0 && nodes_.back().travel_m - nodes_[first].travel_m < loop().context_m) --first;
    PointSet all;
    for (std::size_t s = nodes_[first].scans; s < scans_.size(); ++s) {
      if (scans_[s].sensor != sensor) continue;
      const SE2d T = latest.inverse() * path[scans_[s].update + 1].T_map_base.raw();
      for (std::size_t i = 0; i < scans_[s].points.size(); ++i)
        all.push_back((T * Eigen::Vector2d(scans_[s].points[i].cast<double>())).cast<float>());
    }
    return all;
  }

  void insert_earlier(const Trajectory& path, Sensor sensor, const SE2d& around, RbpfMaps& maps) {
    std::size_t k = 0;
    for (std::size_t s = 0; s < scans_.size(); ++s) {
      while (k + 1 < nodes_.size() && nodes_[k + 1].scans <= s) ++k;
      if (!is_earlier(nodes_[k])) break;
      const SE2d pose = path[scans_[s].update + 1].T_map_base.raw();
      if (scans_[s].sensor == sensor &&
          (pose.translation() - around.translation()).norm() < loop().map_radius_m)
        maker_.insert(maps, pose, scans_[s]);
    }
  }

  static PointSet every_kth(const PointSet& points, std::size_t most) {
    const std::size_t k = (points.size() + most - 1) / std::max<std::size_t>(most, 1);
    PointSet some;
    for (std::size_t i = 0; i < points.size(); i += k) some.push_back(points[i]);
    return some;
  }

  /// Whether a correction is worth rebuilding the maps.
  [[nodiscard]] bool moves(const SE2d& from, const SE2d& to) const {
    const Eigen::Vector3d d = to.minus(from);
    return d.head<2>().norm() > loop().least_m || std::abs(d[2]) > loop().least_turn.radians();
  }

  /// Poses between nodes are corrected as these, in proportion to the updates between.
  [[nodiscard]] Trajectory moved(const Trajectory& path, const std::vector<SE2d>& before) const {
    Trajectory result = path;
    std::size_t k = 0;
    for (std::size_t i = 0; i < path.size(); ++i) {
      while (k + 1 < nodes_.size() && nodes_[k + 1].update + 1 <= i) ++k;
      const SE2d pose = path[i].T_map_base.raw();
      const SE2d a = graph_.poses[k] * before[k].inverse() * pose;
      SE2d corrected = a;
      if (k + 1 < nodes_.size()) {
        const double first = static_cast<double>(nodes_[k].update + 1),
                     last = static_cast<double>(nodes_[k + 1].update + 1);
        const double part = std::clamp((static_cast<double>(i) - first) / (last - first), 0.0, 1.0);
        const SE2d b = graph_.poses[k + 1] * before[k + 1].inverse() * pose;
        corrected = a.plus(part * b.minus(a));
      }
      result[i].T_map_base = MapPose(corrected);
    }
    return result;
  }

  RadarSlamOptions options_;
  MapMaker maker_;
  std::array<bool, 2> uses_{};
  std::vector<MappedScan> scans_;
  std::vector<Node> nodes_;
  std::size_t searched_ = 0, smoothed_ = 0;  // nodes at the last search, and smoothing
  PoseGraph2 graph_;
  std::vector<Edge> odometry_, loops_;
  std::array<std::optional<Edge>, 2> before_;  // the latest match of each sensor
  PoseGraphOptimiser<SE2d> optimiser_;
  OccupancyFieldMaker fields_;
  DetectionFieldMaker densities_;
  LikelihoodField view_;
  PoseProposal proposal_;
};

}  // namespace wayfare
