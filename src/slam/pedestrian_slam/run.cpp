#include <string>
#include <utility>

#include <wayfare/slam/pedestrian_slam.hpp>

namespace wayfare {

Result<PedestrianSlamRun> run_pedestrian_slam(const Recording& recording, const MargRecording& unit,
                                              PedestrianSlamOptions options,
                                              const SlamProgress& progress) {
  options.slam.T_base_laser = recording.T_base_laser;
  PedestrianSlam walker(options);
  PedestrianSlamRun run;
  SubmapSlamRun& slam = run.slam;
  auto reading = unit.begin();
  for (std::size_t i = 0; i < recording.scans.size(); ++i) {
    const LaserScan& scan = recording.scans[i];
    for (; reading != unit.end() && reading->time <= scan.time; ++reading) walker.add(*reading);
    const auto outcome = walker.add_scan(scan);
    if (!outcome && slam.refused_scans++ == 0)
      slam.first_refusal = "scan " + std::to_string(i) + ": " + outcome.error().message;
    const double done = static_cast<double>(i + 1) / static_cast<double>(recording.scans.size());
    if (progress && !progress(done)) break;
  }
  if (walker.slam().statistics().scans == 0)
    return Error{ErrorCode::invalid, recording.scans.empty()
                                         ? "the recording has no scans"
                                         : "no scan could be used; " + slam.first_refusal};
  slam.state = walker.slam().save();
  if (auto ok = walker.finish(); !ok) return ok.error();
  slam.trajectory = walker.slam().trajectory();
  slam.graph = walker.slam().graph();
  slam.map = walker.slam().map();
  slam.statistics = walker.slam().statistics();
  slam.memory_bytes = walker.slam().memory_bytes();
  run.dead_reckoning = walker.dead_reckoning();
  run.step_scale = walker.feedback().scale();
  return run;
}

}  // namespace wayfare
