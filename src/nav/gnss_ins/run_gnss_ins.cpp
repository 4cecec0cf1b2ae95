#include <cstddef>

#include <wayfare/nav/gnss_ins.hpp>

#include "nav/gnss_ins/replay.hpp"

namespace wayfare {

namespace {

Result<GnssInsResult> run_once(const GnssInsRecording& recording, const GnssInsOptions& options,
                               const GnssInsProgress& progress, const std::stop_token& stop) {
  nav::Replay replay{recording, GnssIns(options), from_seconds(options.imu_time_offset_s)};
  if (recording.start) replay.filter.start(*recording.start);
  const std::size_t n = recording.imu.size();
  for (std::size_t i = 0; i < n; ++i) {
    if (i % 1024 == 0) {
      if (stop.stop_requested()) return nav::stopped();
      if (progress) progress(static_cast<double>(i) / static_cast<double>(n));
    }
    replay.step(recording.imu[i]);
  }
  GnssInsResult result = replay.finish();
  if (progress) progress(1.0);
  if (result.points.empty()) return nav::never_started(replay.filter);
  return result;
}

}  // namespace

Result<GnssInsResult> run_gnss_ins(const GnssInsRecording& recording, const GnssInsOptions& options,
                                   const GnssInsProgress& progress, std::stop_token stop) {
  return nav::with_coarse_start(recording, options, [&](const GnssInsOptions& o) {
    return run_once(recording, o, progress, stop);
  });
}

}  // namespace wayfare
