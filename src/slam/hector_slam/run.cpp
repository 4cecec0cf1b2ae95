#include <utility>

#include <wayfare/slam/detail/scans.hpp>
#include <wayfare/slam/hector_slam.hpp>

namespace wayfare {

Result<HectorRun> run_hector_slam(const Recording& recording, HectorSlamOptions options,
                                  const SlamProgress& progress) {
  return run_hector_slam(recording, {}, options, progress);
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
  return HectorRun{slam.trajectory(),         slam.map(),         slam.statistics(), refused->count,
                   std::move(refused->first), slam.memory_bytes()};
}

}  // namespace wayfare
