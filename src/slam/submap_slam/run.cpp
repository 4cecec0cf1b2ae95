#include <utility>

#include <wayfare/slam/submap_slam.hpp>
#include <wayfare/sync/odometry_track.hpp>

#include "slam/feed_scans.hpp"

namespace wayfare {

Result<SubmapSlamRun> run_submap_slam(const Recording& recording, SubmapSlamOptions options,
                                      const SlamProgress& progress,
                                      std::span<const std::uint8_t> saved) {
  options.T_base_laser = recording.T_base_laser;
  SubmapSlam slam(options);
  if (!saved.empty()) {
    auto restored = SubmapSlam::restore(saved, options);
    if (!restored) return restored.error();
    slam = *std::move(restored);
  }
  const OdometryTrack odometry(recording.odometry);
  const GyroTurn gyro(recording.gyro);
  auto refused = detail::feed_scans(slam, recording, progress, [&](std::size_t i) {
    const LogTime time = recording.scans[i].time;
    MotionHint hint{odometry.at(time), {}};
    if (!hint.odometry && i > 0) hint.turn = gyro.between(recording.scans[i - 1].time, time);
    return hint;
  });
  if (!refused) return refused.error();
  SubmapSlamRun run;
  run.refused_scans = refused->count;
  run.first_refusal = std::move(refused->first);
  run.state = slam.save();
  if (auto ok = slam.finish(); !ok) return ok.error();
  run.trajectory = slam.trajectory();
  run.graph = slam.graph();
  run.map = slam.map();
  run.statistics = slam.statistics();
  run.memory_bytes = slam.memory_bytes();
  return run;
}

}  // namespace wayfare
