#include <algorithm>
#include <cmath>

#include <wayfare/core/se3.hpp>
#include <wayfare/sim/vehicle_trajectory.hpp>

namespace wayfare::sim {
namespace {

using Samples = std::vector<CurveSample>;

// The representative of `angle` nearest to `reference`.
double unwrapped(double angle, double reference) {
  return reference + wrap_to_pi(angle - reference);
}

// Heading and grade, without roll, while the vehicle is fast enough to determine them.
Samples course_samples(const SmoothCurve& position, const TrackFit& fit) {
  Samples moving;
  for (double t = position.begin_s(); t <= position.end_s(); t += fit.knot_spacing_s) {
    const Eigen::Vector3d v = position.at(t).first;
    const double speed = v.head<2>().norm();
    if (speed < fit.min_course_speed_mps) continue;
    double yaw = std::atan2(v.y(), v.x());
    if (!moving.empty()) yaw = unwrapped(yaw, moving.back().value[2]);
    const double sigma = 0.3 * fit.velocity_sigma_mps / speed;
    moving.push_back({t, {0.0, std::atan2(-v.z(), speed), yaw}, sigma});
  }
  return moving;
}

// At rest between two drives, the heading difference is spread over the time between.
Samples fill_standstills(const Samples& moving, const SmoothCurve& position, const TrackFit& fit) {
  CurveSample level{position.begin_s(), Eigen::Vector3d::Zero(), 0.05};
  if (moving.empty()) {
    Samples still(3, level);
    still[1].time_s = 0.5 * (position.begin_s() + position.end_s());
    still[2].time_s = position.end_s();
    return still;
  }
  Samples all;
  CurveSample before = moving.front();
  before.time_s = position.begin_s();
  const auto bridge = [&](const CurveSample& after) {
    const double gap = after.time_s - before.time_s;
    for (double t = fit.knot_spacing_s; t < gap - 0.5 * fit.knot_spacing_s; t += fit.knot_spacing_s)
      all.push_back(
          {before.time_s + t, before.value + t / gap * (after.value - before.value), 0.02});
  };
  for (const CurveSample& sample : moving) {
    bridge(sample);
    all.push_back(sample);
    before = sample;
  }
  CurveSample last = before;
  last.time_s = position.end_s();
  bridge(last);
  return all;
}

Samples recorded_attitudes(std::span<const NavState> solution) {
  Samples all;
  for (const NavState& s : solution) {
    Eigen::Vector3d rpy = roll_pitch_yaw_rad(s.q_nb);
    if (!all.empty())
      for (int i : {0, 2}) rpy[i] = unwrapped(rpy[i], all.back().value[i]);
    all.push_back({to_seconds(s.time - solution.front().time), rpy, 1e-3});
  }
  return all;
}

}  // namespace

Result<VehicleTrajectory> follow_solution(std::span<const NavState> solution, const TrackFit& fit) {
  if (solution.size() < 4)
    return Error{ErrorCode::invalid, "a track needs four states or more to be followed"};
  const NavState& first = solution.front();
  Samples samples;
  double end_s = 0.0;
  for (const NavState& s : solution) {
    const double t = to_seconds(s.time - first.time);
    if (t < end_s)
      return Error{ErrorCode::invalid, "the states of a track are not in order of time"};
    end_s = t;
    const Eigen::Matrix3d origin_ned =
        rotation_ecef_ned(first.position).transpose() * rotation_ecef_ned(s.position);
    samples.push_back({t, ned_from_geodetic(s.position, first.position), fit.position_sigma_m});
    const double held_s = t - fit.velocity_late_s;
    if (held_s >= 0.0)
      samples.push_back({held_s, origin_ned * s.velocity_ned_mps, fit.velocity_sigma_mps,
                         CurveSample::Of::derivative});
  }
  auto position = SmoothCurve::fit(samples, 0.0, end_s, {fit.knot_spacing_s, fit.jerk_sigma_mps3});
  if (!position) return position.error();
  const Samples turned = fit.attitude_from_course
                             ? fill_standstills(course_samples(*position, fit), *position, fit)
                             : recorded_attitudes(solution);
  auto attitude = SmoothCurve::fit(turned, 0.0, end_s, {fit.knot_spacing_s, 1.0});
  if (!attitude) return attitude.error();
  return VehicleTrajectory(first.position, first.time, std::move(position).value(),
                           std::move(attitude).value());
}

}  // namespace wayfare::sim
