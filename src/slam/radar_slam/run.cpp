#include <algorithm>
#include <optional>

#include <wayfare/slam/radar_slam.hpp>

namespace wayfare {
namespace {

MotionSource motion_of(const Recording& recording) {
  if (!recording.wheels.empty()) return MotionSource::wheels;
  return recording.odometry.empty() ? MotionSource::none : MotionSource::odometry;
}

/// Share of the recording before a time, [0, 1].
class Share {
 public:
  explicit Share(const Recording& recording) {
    include(recording.scans), include(recording.radar), include(recording.wheels);
  }
  [[nodiscard]] double at(LogTime time) const {
    const double whole_s = to_seconds(last_ - *first_);
    return whole_s > 0 ? std::clamp(to_seconds(time - *first_) / whole_s, 0.0, 1.0) : 1.0;
  }

 private:
  template <class Stream>
  void include(const Stream& stream) {
    if (stream.empty()) return;
    last_ = first_ ? std::max(last_, stream.back().time) : stream.back().time;
    first_ = first_ ? std::min(*first_, stream.front().time) : stream.front().time;
  }

  std::optional<LogTime> first_;
  LogTime last_;
};

}  // namespace

Result<RadarSlamRun> run_radar_slam(const Recording& recording, RadarSlamOptions options,
                                    SlamSensors sensors, const SlamProgress& progress,
                                    const DeadReckoningOptions& reckoning) {
  options.T_base_laser = recording.T_base_laser;
  RadarSlamStream stream(
      {options, sensors, motion_of(recording), reckoning, sync_params(recording)});
  const auto add_all = [&](const auto& measurements) {
    for (const auto& measurement : measurements) stream.add(measurement);
  };
  add_all(recording.wheels), add_all(recording.gyro), add_all(recording.odometry);
  add_all(recording.radar), add_all(recording.scans);
  stream.finish();
  const Share share(recording);
  while (const auto time = stream.step())
    if (progress && !progress(share.at(*time))) break;
  RadarSlamRun run = stream.result();
  if (run.statistics.updates > 0) return run;
  return Error{ErrorCode::invalid,
               "no scan could be used" + (run.refused_scans > 0 ? "; " + run.first_refusal : "")};
}

}  // namespace wayfare
