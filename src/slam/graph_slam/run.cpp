#include <string>
#include <utility>

#include <wayfare/sync/odometry_track.hpp>
#include <wayfare/system/graph_slam.hpp>

namespace wayfare {
namespace {

/// Scans that were not taken, and why the first of them was not.
struct Refusals {
  std::size_t count = 0;
  std::string first;
};

Refusals feed(GraphSlam& slam, const Recording& recording, const SlamProgress& progress) {
  const OdometryTrack odometry(recording.odometry);
  Refusals refused;
  for (std::size_t i = 0; i < recording.scans.size(); ++i) {
    const LaserScan& scan = recording.scans[i];
    const auto outcome = slam.add_scan(scan, odometry.at(scan.time));
    if (!outcome && refused.count++ == 0) {
      refused.first = "scan " + std::to_string(i) + ": " + outcome.error().message;
    }
    const double done = static_cast<double>(i + 1) / static_cast<double>(recording.scans.size());
    if (progress && !progress(done)) break;
  }
  return refused;
}

}  // namespace

Result<GraphSlamRun> run_graph_slam(const Recording& recording, GraphSlamOptions options,
                                    const SlamProgress& progress) {
  options.T_base_laser = recording.T_base_laser;
  GraphSlam slam(options);
  Refusals refused = feed(slam, recording, progress);
  if (slam.statistics().scans == 0) {
    return Error{ErrorCode::invalid, recording.scans.empty()
                                         ? "the recording has no scans"
                                         : "no scan could be used; " + refused.first};
  }
  if (auto ok = slam.finish(); !ok) return ok.error();
  return GraphSlamRun{slam.trajectory(), slam.graph(),  slam.map(),
                      slam.statistics(), refused.count, std::move(refused.first)};
}

}  // namespace wayfare
