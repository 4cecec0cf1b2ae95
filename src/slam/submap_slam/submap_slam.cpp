#include <wayfare/slam/submap_slam.hpp>

#include <algorithm>
#include <utility>

#include <wayfare/core/gaussian.hpp>
#include <wayfare/slam/detail/graph_slam/wall_crossings.hpp>
#include <wayfare/slam/detail/scans.hpp>

#include "slam/submap_slam/engine.hpp"

namespace wayfare {
namespace {

detail::SubmapMaps default_maps(const SubmapSlamOptions& options) {
  GaussNewtonOptions smooth;
  smooth.interpolation = Interpolation::bicubic;
  smooth.max_iterations = 30;
  return detail::submap_maps(GaussNewtonMatcher(options.match), GaussNewtonMatcher(smooth),
                             options.grid, options.T_base_laser.raw().translation());
}

}  // namespace

Trajectory SubmapSlamSystem::Engine::trajectory() const {
  Trajectory result = forgotten_;
  result.reserve(forgotten_.size() + scans_.size());
  for (const ScanPose& s : scans_)
    result.push_back({s.time, MapPose(map_.pose(s.node) * s.T_node_base)});
  return result;
}

Trajectory SubmapSlamSystem::Engine::latest_trajectory() const {
  if (!pieces_.are_several()) return trajectory();
  const int part = pieces_.part_of(map_.latest());
  Trajectory result;
  for (const ScanPose& s : scans_)
    if (pieces_.part_of(s.node) == part)
      result.push_back({s.time, MapPose(map_.pose(s.node) * s.T_node_base)});
  return result;
}

OccupancyGrid SubmapSlamSystem::Engine::map(const OccupancyGridOptions& shape,
                                            const InverseLidarModel& model) const {
  return map_of(shape, model, [&](int k) { return !pieces_.is_in_small_part(k); });
}
OccupancyGrid SubmapSlamSystem::Engine::latest_part(const OccupancyGridOptions& shape,
                                                    const InverseLidarModel& model) const {
  const int part = pieces_.part_of(map_.latest());
  return map_of(shape, model, [&](int k) { return pieces_.part_of(k) == part; });
}

template <class Includes>
OccupancyGrid SubmapSlamSystem::Engine::map_of(const OccupancyGridOptions& shape,
                                               const InverseLidarModel& model,
                                               const Includes& includes) const {
  OccupancyGrid grid(shape);
  ScanRaster raster;
  const Eigen::Vector2d laser = options_.T_base_laser.raw().translation();
  for (int k = 0; k <= map_.latest(); ++k) {
    if (!includes(k)) continue;
    // A scan too large for the raster is left out of the map.
    (void)insert_points(grid, map_.pose(k), map_.node(k).points->unpacked(), model, raster, laser);
  }
  return grid;
}

WallCrossings SubmapSlamSystem::Engine::wall_crossings(const OccupancyGrid& map) const {
  std::vector<PointSet> points;
  std::vector<SE2d> poses;
  for (int k = 0; k <= map_.latest(); k += 3) {
    if (pieces_.is_in_small_part(k)) continue;
    points.push_back(map_.node(k).points->unpacked());
    poses.push_back(map_.pose(k));
  }
  std::vector<PlacedPoints> scans;
  for (std::size_t i = 0; i < points.size(); ++i) scans.push_back({&points[i], poses[i]});
  return detail::wall_crossings(scans, map, options_.T_base_laser.raw().translation());
}

/// Of the latest node, and of the scan placed from there.
Eigen::Matrix3d SubmapSlamSystem::Engine::covariance() {
  if (scans_.empty()) return Eigen::Matrix3d::Zero();
  const Eigen::Matrix3d& node = uncertainty_.of_latest(
      map_, pieces_.first_of_part(map_.latest()),
      {statistics_.nodes, map_.graph.edges.size(), statistics_.optimisations});
  const SE2d& since = scans_.back().T_node_base;
  const Eigen::Matrix3d step = placed_ + options_.drift.covariance(since.translation().norm());
  return compose(Gaussian<SE2d>{SE2d(), node}, Gaussian<SE2d>{since, step}).covariance;
}

std::size_t SubmapSlamSystem::Engine::memory_bytes() {
  std::size_t sum = tracker_.memory_bytes() + search_.memory_bytes();
  for (const SubmapNode& n : map_.nodes) sum += n.points->xy().size() * sizeof(std::int16_t);
  sum += map_.graph.edges.size() * sizeof(PoseEdge<SE2d>);
  return sum + scans_.size() * sizeof(ScanPose) + forgotten_.size() * sizeof(StampedPose);
}

SubmapSlamSystem::SubmapSlamSystem(const SubmapSlamOptions& options)
    : SubmapSlamSystem(options, default_maps(options)) {}
SubmapSlamSystem::SubmapSlamSystem(const SubmapSlamOptions& options, detail::SubmapMaps maps)
    : engine_(detail::make_owned<Engine>(options, std::move(maps))) {}

Result<ScanOutcome> SubmapSlamSystem::add_scan(const LaserScan& scan, const MotionHint& hint) {
  return engine_->add_scan(scan, hint);
}
Result<void> SubmapSlamSystem::finish() { return engine_->finish(); }
Trajectory SubmapSlamSystem::trajectory() const { return engine_->trajectory(); }
const PoseGraph2& SubmapSlamSystem::graph() const { return engine_->graph(); }
const SubmapSlamStatistics& SubmapSlamSystem::statistics() const { return engine_->statistics(); }
const LocalPlacement& SubmapSlamSystem::local() const { return engine_->local(); }
Eigen::Matrix3d SubmapSlamSystem::covariance() const { return engine_->covariance(); }
OccupancyGrid SubmapSlamSystem::map(const OccupancyGridOptions& shape,
                                    const InverseLidarModel& model) const {
  return engine_->map(shape, model);
}
OccupancyGrid SubmapSlamSystem::latest_part(const OccupancyGridOptions& shape,
                                            const InverseLidarModel& model) const {
  return engine_->latest_part(shape, model);
}
Trajectory SubmapSlamSystem::latest_trajectory() const { return engine_->latest_trajectory(); }
WallCrossings SubmapSlamSystem::wall_crossings(const OccupancyGrid& map) const {
  return engine_->wall_crossings(map);
}
std::size_t SubmapSlamSystem::memory_bytes() const { return engine_->memory_bytes(); }
void SubmapSlamSystem::drop_tables() { engine_->drop_tables(); }
std::vector<std::uint8_t> SubmapSlamSystem::save() const { return engine_->save(); }

Result<void> SubmapSlamSystem::load(std::span<const std::uint8_t> bytes) {
  return engine_->restore(bytes);
}

Result<SubmapSlamRun> run_submap_slam(const Recording& recording, SubmapSlamOptions options,
                                      const SlamProgress& progress,
                                      std::span<const std::uint8_t> saved) {
  options.T_base_laser = recording.T_base_laser;
  auto slam = saved.empty() ? SubmapSlam(options) : SubmapSlam::restore(saved, options);
  return slam ? detail::run(*slam, recording, progress) : slam.error();
}

Result<SubmapSlamRun> detail::run(SubmapSlamSystem& slam, const Recording& recording,
                                  const SlamProgress& progress) {
  const GyroTurn gyro(recording.gyro);
  ScanDeskewer deskewer(recording.T_base_laser);
  auto refused = detail::feed_scans(recording, progress, slam.statistics(), [&](std::size_t i) {
    return detail::add_deskewed(deskewer, recording, i, [&](const LaserScan& scan) {
      MotionHint hint{OdometryTrack(recording.odometry).at(scan.time), {}};
      if (!hint.odometry && i > 0) hint.turn = gyro.between(recording.scans[i - 1].time, scan.time);
      return slam.add_scan(scan, hint);
    });
  });
  return refused ? finished_run(slam, *std::move(refused)) : refused.error();
}

Result<SubmapSlamRun> detail::finished_run(SubmapSlamSystem& slam, Refusals refused) {
  SubmapSlamRun run;
  run.refused_scans = refused.count;
  run.first_refusal = std::move(refused.first);
  run.state = slam.save();
  if (auto ok = slam.finish(); !ok) return ok.error();
  run.memory_bytes = slam.memory_bytes();
  slam.drop_tables();
  run.trajectory = slam.trajectory();
  run.graph = slam.graph();
  run.map = slam.map();
  run.statistics = slam.statistics();
  run.crossings = slam.wall_crossings(run.map);
  return run;
}

}  // namespace wayfare
