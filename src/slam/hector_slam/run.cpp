#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include <wayfare/map/likelihood_field.hpp>
#include <wayfare/map/occupancy_grid.hpp>
#include <wayfare/sensors/point_set.hpp>
#include <wayfare/slam/detail/graph_slam/wall_crossings.hpp>
#include <wayfare/slam/detail/scans.hpp>
#include <wayfare/slam/hector_slam.hpp>

namespace wayfare {
namespace {

/// Of a fifth of the beams of scans that are 0.2 m or 10° apart.
WallCrossings crossings_of(const Recording& recording, const Trajectory& trajectory,
                           const OccupancyGrid& map) {
  constexpr double kApart_m = 0.2, kTurned_rad = 0.17;
  constexpr std::size_t kBeams = 5;
  std::vector<PointSet> points;
  std::vector<SE2d> poses;
  auto pose = trajectory.begin();
  for (const LaserScan& scan : recording.scans) {
    while (pose != trajectory.end() && pose->time < scan.time) ++pose;
    if (pose == trajectory.end() || pose->time > scan.end_time()) continue;
    const SE2d at = pose->T_map_base.raw();
    if (!poses.empty() && (at.translation() - poses.back().translation()).norm() < kApart_m &&
        std::abs((at.heading() - poses.back().heading()).radians()) < kTurned_rad)
      continue;
    const PointSet all = end_points(scan, recording.T_base_laser.raw());
    PointSet& some = points.emplace_back();
    for (std::size_t i = 0; i < all.size(); i += kBeams) some.push_back(all[i]);
    poses.push_back(at);
  }
  std::vector<PlacedPoints> scans;
  for (std::size_t i = 0; i < poses.size(); ++i) scans.push_back({&points[i], poses[i]});
  return detail::wall_crossings(scans, map, recording.T_base_laser.raw().translation());
}

}  // namespace

Result<HectorRun> run_hector_slam(const Recording& recording, HectorSlamOptions options,
                                  const SlamProgress& progress) {
  return run_hector_slam(recording, {}, std::move(options), progress);
}

Result<HectorRun> run_hector_slam(const Recording& recording, const MargRecording& unit,
                                  HectorSlamOptions options, const SlamProgress& progress) {
  options.T_base_laser = recording.T_base_laser;
  HectorSlam slam(options);
  return detail::run(slam, recording, unit, progress);
}

Result<HectorRun> detail::run(HectorSlamSystem& slam, const Recording& recording,
                              const MargRecording& unit, const SlamProgress& progress) {
  const OdometryTrack odometry(recording.odometry);
  ScanDeskewer deskewer(recording.T_base_laser);
  auto reading = unit.begin();
  auto refused = detail::feed_scans(recording, progress, slam.statistics(), [&](std::size_t i) {
    const LogTime end = recording.scans[i].end_time();
    for (; reading != unit.end() && reading->time <= end; ++reading)
      slam.add(ImuSample{reading->time, reading->angular_rate_radps, reading->specific_force_mps2});
    if (!unit.empty()) return slam.add_scan(recording.scans[i], odometry.at(end));
    return detail::add_deskewed(deskewer, recording, i, [&](const LaserScan& scan) {
      return slam.add_scan(scan, odometry.at(scan.time));
    });
  });
  if (!refused) return refused.error();
  HectorRun run{
      slam.trajectory(),   slam.map(), slam.statistics(), refused->count, std::move(refused->first),
      slam.memory_bytes(), {}};
  run.crossings = crossings_of(recording, run.trajectory, run.map);
  return run;
}

}  // namespace wayfare
