#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include <wayfare/core/result.hpp>
#include <wayfare/map/occupancy_grid.hpp>
#include <wayfare/slam/detail/graph_slam/wall_crossings.hpp>
#include <wayfare/slam/detail/scans.hpp>
#include <wayfare/slam/graph_slam.hpp>
#include <wayfare/sync/odometry_track.hpp>

namespace wayfare::detail {

/// Runs a graph SLAM over a recording; `state`, if given, becomes that after the last scan.
template <class Slam>
Result<GraphSlamRun> run_over(Slam slam, const Recording& recording, const SlamProgress& progress,
                              std::vector<std::uint8_t>* state) {
  const OdometryTrack odometry(recording.odometry);
  ScanDeskewer deskewer(recording.T_base_laser);
  auto refused = feed_scans(recording, progress, slam.statistics(), [&](std::size_t i) {
    return add_deskewed(deskewer, recording, i, [&](const LaserScan& scan) {
      return slam.add_scan(scan, odometry.at(scan.time));
    });
  });
  if (!refused) return refused.error();
  if (state != nullptr) *state = slam.save();
  if (auto ok = slam.finish(); !ok) return ok.error();
  OccupancyGrid map = slam.map();
  const WallCrossings crossings = slam.wall_crossings(map);
  return GraphSlamRun{slam.trajectory(), slam.graph(),   std::move(map),
                      slam.statistics(), refused->count, std::move(refused->first),
                      crossings};
}

}  // namespace wayfare::detail
