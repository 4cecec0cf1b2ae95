#include <string>
#include <utility>

#include <wayfare/sync/odometry_track.hpp>
#include <wayfare/system/hector_slam.hpp>

namespace wayfare {

Result<HectorRun> run_hector_slam(const Recording& recording, HectorSlamOptions options,
                                  const SlamProgress& progress) {
  options.T_base_laser = recording.T_base_laser;
  HectorSlam slam(options);
  const OdometryTrack odometry(recording.odometry);
  HectorRun run;
  for (std::size_t i = 0; i < recording.scans.size(); ++i) {
    const LaserScan& scan = recording.scans[i];
    const auto outcome = slam.add_scan(scan, odometry.at(scan.time));
    if (!outcome && run.refused_scans++ == 0)
      run.first_refusal = "scan " + std::to_string(i) + ": " + outcome.error().message;
    const double done = static_cast<double>(i + 1) / static_cast<double>(recording.scans.size());
    if (progress && !progress(done)) break;
  }
  run.statistics = slam.statistics();
  if (run.statistics.scans == 0)
    return Error{ErrorCode::invalid, recording.scans.empty()
                                         ? "the recording has no scans"
                                         : "no scan could be used; " + run.first_refusal};
  run.trajectory = slam.trajectory();
  run.map = slam.map();
  return run;
}

}  // namespace wayfare
