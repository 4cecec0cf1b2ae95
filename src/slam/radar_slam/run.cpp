#include <wayfare/slam/radar_slam.hpp>

#include <algorithm>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <wayfare/slam/detail/scans.hpp>
#include <wayfare/sync/scan_deskewer.hpp>

namespace wayfare {
namespace {

/// The wheels of a robot that moved by the odometry; sideways motion is lost.
std::vector<WheelSample> wheels_of(std::span<const OdometrySample> odometry, double wheel_base_m) {
  std::vector<WheelSample> wheels;
  const OdometrySample* before = nullptr;
  for (const OdometrySample& now : odometry) {
    const SE2d& from = before != nullptr ? before->T_odom_base.raw() : now.T_odom_base.raw();
    const Eigen::Vector3d twist = (from.inverse() * now.T_odom_base.raw()).log();
    const double half_turn_m = 0.5 * wheel_base_m * twist.z();
    wheels.push_back({now.time, twist.x() - half_turn_m, twist.x() + half_turn_m});
    before = &now;
  }
  return wheels;
}

}  // namespace

Result<RadarSlamRun> run_radar_slam(const Recording& recording, RadarSlamOptions options,
                                    SlamSensors sensors, const SlamProgress& progress,
                                    const DeadReckoningOptions& reckoning, const SyncParams& sync) {
  options.T_base_laser = recording.T_base_laser;
  SyncParams streams = sync_params(recording, sync);
  std::vector<WheelSample> wheels = recording.wheels;
  if (wheels.empty() && !recording.gyro.empty()) {
    if (!(streams.wheel_base_m > 0.0)) streams.wheel_base_m = reckoning.wheels.wheel_base_m;
    wheels = wheels_of(recording.odometry, streams.wheel_base_m);
  }
  const MotionSource motion = !wheels.empty()               ? MotionSource::wheels
                              : !recording.odometry.empty() ? MotionSource::odometry
                                                            : MotionSource::none;
  RadarSlamStream stream({options, sensors, motion, reckoning, streams});
  const auto add_all = [&](const auto& measurements) {
    for (const auto& measurement : measurements) stream.add(measurement);
  };
  add_all(wheels), add_all(recording.gyro), add_all(recording.odometry);
  add_all(recording.radar);
  ScanDeskewer deskewer(recording.T_base_laser);
  detail::Refusals refused;
  for (std::size_t i = 0; i < recording.scans.size(); ++i) {
    const auto instant = deskewer(recording.scans[i], recording.odometry, recording.gyro);
    refused.add(instant, "scan " + std::to_string(i));
    if (instant) stream.add(**instant);
  }
  stream.finish();
  std::optional<LogTime> first, last;
  const auto include = [&](const auto& measurements) {
    if (measurements.empty()) return;
    first = std::min(first.value_or(measurements.front().time), measurements.front().time);
    last = std::max(last.value_or(measurements.back().time), measurements.back().time);
  };
  include(recording.scans), include(recording.radar), include(wheels);
  while (const auto time = stream.step()) {
    const double whole_s = to_seconds(*last - *first), done_s = to_seconds(*time - *first);
    if (progress && !progress(whole_s > 0 ? std::clamp(done_s / whole_s, 0.0, 1.0) : 1.0)) break;
  }
  stream.join_pieces();
  RadarSlamRun run = stream.result();
  if (refused.count > 0 && run.refused_scans == 0) run.first_refusal = refused.first;
  run.refused_scans += refused.count;
  if (run.statistics.updates > 0) return run;
  return Error{ErrorCode::invalid,
               "no scan could be used" + (run.refused_scans > 0 ? "; " + run.first_refusal : "")};
}

}  // namespace wayfare
