#include <utility>

#include <wayfare/slam/hector_slam.hpp>

#include "slam/feed_scans.hpp"

namespace wayfare {

namespace {

HectorRun ended(const HectorSlam& slam, detail::Refusals&& refused) {
  return {slam.trajectory(), slam.map(), slam.statistics(), refused.count,
          std::move(refused.first)};
}

}  // namespace

Result<HectorRun> run_hector_slam(const Recording& recording, HectorSlamOptions options,
                                  const SlamProgress& progress) {
  return run_hector_slam(recording, {}, options, progress);
}

Result<HectorRun> run_hector_slam(const Recording& recording, const MargRecording& unit,
                                  HectorSlamOptions options, const SlamProgress& progress) {
  options.T_base_laser = recording.T_base_laser;
  HectorSlam slam(options);
  const OdometryTrack odometry(recording.odometry);
  auto reading = unit.begin();
  auto refused = detail::feed_scans(slam, recording, progress, [&](std::size_t i) {
    const LogTime time = recording.scans[i].time;
    for (; reading != unit.end() && reading->time <= time; ++reading)
      slam.add(ImuSample{reading->time, reading->angular_rate_radps, reading->specific_force_mps2});
    return odometry.at(time);
  });
  if (!refused) return refused.error();
  return ended(slam, std::move(*refused));
}

}  // namespace wayfare
