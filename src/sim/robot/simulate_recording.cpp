#include <wayfare/sim/simulate_recording.hpp>

#include <algorithm>
#include <cstdio>
#include <string>
#include <vector>

namespace wayfare::sim {
namespace {

enum RobotStream : std::uint64_t { kWheels, kGyro, kLidar };

std::string place(const Eigen::Vector2d& p) {
  char text[64];
  std::snprintf(text, sizeof text, "(%.2f, %.2f)", p.x(), p.y());
  return text;
}

Result<void> check_route(const FloorPlan& plan, std::span<const Eigen::Vector2d> route_m) {
  if (route_m.size() < 2) return Error{ErrorCode::invalid, "a route needs two waypoints or more"};
  for (std::size_t i = 1; i < route_m.size(); ++i) {
    if (!plan.blocks(route_m[i - 1], route_m[i])) continue;
    return Error{ErrorCode::invalid, "the route leads through a wall between waypoint " +
                                         std::to_string(i - 1) + " at " + place(route_m[i - 1]) +
                                         " and waypoint " + std::to_string(i) + " at " +
                                         place(route_m[i])};
  }
  if (const auto leak = find_leak(plan, route_m[0])) {
    return Error{ErrorCode::invalid, "the plan is not closed: from the start at " +
                                         place(route_m[0]) + " the outside can be reached at " +
                                         place(*leak)};
  }
  return {};
}

Result<void> check_clearance(const FloorPlan& plan, const Trajectory& truth, double radius_m) {
  for (const StampedPose& pose : truth) {
    const Eigen::Vector2d& p = pose.T_map_base.raw().translation();
    if (!(plan.clearance(p, radius_m) < radius_m)) continue;
    return Error{ErrorCode::invalid, "the robot would touch a wall at " + place(p)};
  }
  return {};
}

Result<std::vector<LaserScan>> record_scans(const FloorPlan& plan, const Trajectory& truth,
                                            const RobotParams& params, const Rng& rng,
                                            const SimulationControl& control) {
  const auto T_plan_laser = [&](LogTime t) {
    return true_pose_at(truth, t) * params.T_base_laser.raw();
  };
  std::vector<LaserScan> scans;
  const LogTime start = truth.front().time;
  const double length_s = std::max(1e-9, to_seconds(truth.back().time - start));
  for (LogTime t = start; t + params.lidar.sweep <= truth.back().time; t += params.scan_period) {
    if (control.stop.stop_requested()) return Error{ErrorCode::cancelled, "stopped on request"};
    Rng noise = rng.stream(scans.size());
    scans.push_back(simulate_scan(plan, T_plan_laser, t, params.lidar, noise));
    if (control.progress) control.progress(to_seconds(t - start) / length_s);
  }
  return scans;
}

template <class Visit>
void for_each_stream(Recording& r, const Visit& visit) {
  visit(r.scans), visit(r.odometry), visit(r.radar), visit(r.wheels), visit(r.gyro), visit(r.truth);
}

}  // namespace

Result<SimulatedRun> simulate_recording(const FloorPlan& plan,
                                        std::span<const Eigen::Vector2d> route_m,
                                        const RobotParams& params, const Rng& rng,
                                        const SimulationControl& control) {
  WAYFARE_EXPECTS(params.scan_period > Duration::zero(), "scans need a positive period");
  auto truth = drive_route(route_m, params.drive);
  if (!truth) return truth.error();
  if (auto ok = check_route(plan, route_m); !ok) return ok.error();
  if (auto ok = check_clearance(plan, *truth, params.radius_m); !ok) return ok.error();

  SimulatedRun run;
  Rng wheel_noise = rng.stream(kWheels), gyro_noise = rng.stream(kGyro);
  run.wheels = simulate_wheels(*truth, params.odometry_period, params.wheels, wheel_noise);
  run.gyro = simulate_gyro(*truth, params.odometry_period, params.gyro, gyro_noise);
  run.recording.T_base_laser = params.T_base_laser;
  run.recording.odometry = params.heading == HeadingSource::wheels
                               ? dead_reckon(run.wheels, params.wheels.wheel_base_m)
                               : dead_reckon(run.wheels, run.gyro);
  auto scans = record_scans(plan, *truth, params, rng.stream(kLidar), control);
  if (!scans) return scans.error();
  run.recording.scans = std::move(scans).value();
  run.truth = std::move(truth).value();
  return run;
}

Recording part_of(const Recording& recording, LogTime from, LogTime to) {
  Recording part = recording;
  for_each_stream(part, [&](auto& stream) {
    std::erase_if(stream, [&](const auto& s) { return s.time < from || s.time >= to; });
  });
  return part;
}

Recording kidnapped(const Recording& recording, LogTime from, LogTime to) {
  Recording result = recording;
  const auto in_between = [&](const auto& s) { return s.time >= from && s.time < to; };
  for_each_stream(result, [&](auto& stream) {
    std::erase_if(stream, in_between);
    for (auto& s : stream)
      if (s.time >= to) s.time = s.time - (to - from);
  });
  std::vector<OdometrySample>& odometry = result.odometry;
  const auto rest = std::find_if(odometry.begin(), odometry.end(),
                                 [&](const OdometrySample& s) { return s.time >= from; });
  if (rest == odometry.begin() || rest == odometry.end()) return result;
  const SE2d T = (rest - 1)->T_odom_base.raw() * rest->T_odom_base.raw().inverse();
  std::for_each(rest, odometry.end(), [&](OdometrySample& s) {
    s.T_odom_base = Transform2<frame::Odom, frame::Base>(T * s.T_odom_base.raw());
  });
  return result;
}

}  // namespace wayfare::sim
