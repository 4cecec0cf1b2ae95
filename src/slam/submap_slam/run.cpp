#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include <wayfare/sync/odometry_track.hpp>
#include <wayfare/system/submap_slam.hpp>

namespace wayfare {
namespace {

/// The turn between two times by a gyroscope's mean rates; none where it is silent.
class GyroTurn {
 public:
  explicit GyroTurn(const std::vector<GyroSample>& samples) : samples_(samples) {}

  [[nodiscard]] std::optional<Angle> between(LogTime from, LogTime to) const {
    constexpr double kSilence_s = 0.5;
    auto s = std::partition_point(samples_.begin(), samples_.end(),
                                  [&](const GyroSample& g) { return g.time <= from; });
    double turn = 0.0;
    LogTime at = from;
    for (; s != samples_.end() && at < to; ++s) {
      const LogTime end = std::min(s->time, to);
      if (!(to_seconds(s->time - at) < kSilence_s) || !std::isfinite(s->turn_rate_rad_s))
        return std::nullopt;
      turn += s->turn_rate_rad_s * to_seconds(end - at);
      at = end;
    }
    if (at < to) return std::nullopt;
    return Angle::radians(turn);
  }

 private:
  const std::vector<GyroSample>& samples_;
};

void feed(SubmapSlam& slam, const Recording& recording, const SlamProgress& progress,
          SubmapSlamRun& run) {
  const OdometryTrack odometry(recording.odometry);
  const GyroTurn gyro(recording.gyro);
  for (std::size_t i = 0; i < recording.scans.size(); ++i) {
    const LaserScan& scan = recording.scans[i];
    MotionHint hint{odometry.at(scan.time), {}};
    if (!hint.odometry && i > 0) hint.turn = gyro.between(recording.scans[i - 1].time, scan.time);
    const auto outcome = slam.add_scan(scan, hint);
    if (!outcome && run.refused_scans++ == 0)
      run.first_refusal = "scan " + std::to_string(i) + ": " + outcome.error().message;
    const double done = static_cast<double>(i + 1) / static_cast<double>(recording.scans.size());
    if (progress && !progress(done)) break;
  }
}

}  // namespace

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
  SubmapSlamRun run;
  feed(slam, recording, progress, run);
  if (slam.statistics().scans == 0)
    return Error{ErrorCode::invalid, recording.scans.empty()
                                         ? "the recording has no scans"
                                         : "no scan could be used; " + run.first_refusal};
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
