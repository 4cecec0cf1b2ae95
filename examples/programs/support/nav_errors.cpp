#include "nav_errors.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <wayfare/core/so3.hpp>
#include <wayfare/gnss/single_point.hpp>

namespace wayfare::examples {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kCourseSpeed_mps = 3.0;

double wrapped_deg(double rad) { return std::remainder(rad, 2.0 * std::numbers::pi) / kDegree; }

/// The last state not after `time`; nothing outside of the states.
template <class State, class TimeOf>
std::optional<std::size_t> before(const std::vector<State>& states, LogTime time, TimeOf time_of) {
  const auto after = std::upper_bound(states.begin(), states.end(), time,
                                      [&](LogTime t, const State& s) { return t < time_of(s); });
  if (after == states.begin()) return std::nullopt;
  const auto i = static_cast<std::size_t>(after - states.begin()) - 1;
  if (after == states.end() && time_of(states[i]) != time) return std::nullopt;
  return i;
}

NavState between(const NavState& a, const NavState& b, double k, bool cubic, double h_s) {
  NavState s = a;
  const Eigen::Vector3d step = ned_from_geodetic(b.position, a.position);
  Eigen::Vector3d moved = k * step;
  if (cubic) {  // Hermite interpolation
    const double k2 = k * k, k3 = k2 * k;
    moved = (3.0 * k2 - 2.0 * k3) * step + (k3 - 2.0 * k2 + k) * h_s * a.velocity_ned_mps +
            (k3 - k2) * h_s * b.velocity_ned_mps;
  }
  s.position = geodetic_from_ned(moved, a.position);
  s.velocity_ned_mps += k * (b.velocity_ned_mps - a.velocity_ned_mps);
  s.q_nb = a.q_nb.plus(k * b.q_nb.minus(a.q_nb));
  s.time = a.time + from_seconds(k * h_s);
  return s;
}

}  // namespace

double since_start(const NavRecording& r, LogTime t) {
  return to_seconds(t - r.recording.imu.front().time);
}

std::optional<NavState> reference_at(const NavTrajectory& reference, bool has_velocity,
                                     LogTime time) {
  const auto i = before(reference, time, [](const NavState& s) { return s.time; });
  if (!i) return std::nullopt;
  if (reference[*i].time == time) return reference[*i];
  const NavState &a = reference[*i], &b = reference[*i + 1];
  const double h_s = to_seconds(b.time - a.time);
  if (h_s > 1.5) return std::nullopt;
  return between(a, b, to_seconds(time - a.time) / h_s, has_velocity, h_s);
}

std::optional<GnssInsPoint> point_at(const std::vector<GnssInsPoint>& points, LogTime time) {
  const auto i = before(points, time, [](const GnssInsPoint& p) { return p.nav.time; });
  if (!i) return std::nullopt;
  GnssInsPoint p = points[*i];
  if (p.nav.time == time) return p;
  const double h_s = to_seconds(points[*i + 1].nav.time - p.nav.time);
  if (h_s > 0.5) return std::nullopt;
  p.nav = between(p.nav, points[*i + 1].nav, to_seconds(time - p.nav.time) / h_s, false, h_s);
  return p;
}

NavState at_lever_arm(const NavState& unit, const Eigen::Vector3d& lever_arm_m,
                      const Eigen::Vector3d& body_rate_radps) {
  NavState s = unit;
  s.position = geodetic_from_ned(unit.q_nb * lever_arm_m, unit.position);
  s.velocity_ned_mps += unit.q_nb * body_rate_radps.cross(lever_arm_m).eval();
  return s;
}

double NavErrors::horizontal(std::size_t i) const { return std::hypot(error[0][i], error[1][i]); }

NavErrors nav_errors(const std::vector<GnssInsPoint>& points, const NavRecording& recording,
                     const NavConfig& config) {
  NavErrors result;
  const Eigen::Vector3d lever =
      config.truth_is_antenna ? config.filter.antenna_lever_arm_m : Eigen::Vector3d::Zero().eval();
  for (const NavState& truth : recording.truth) {
    const auto p = point_at(points, truth.time);
    if (!p) continue;
    const Duration step = std::chrono::milliseconds(20);
    const auto next = point_at(points, truth.time + step);
    const Eigen::Vector3d rate =
        next ? Eigen::Vector3d(next->nav.q_nb.minus(p->nav.q_nb) / to_seconds(step))
             : Eigen::Vector3d::Zero().eval();
    const NavState e = at_lever_arm(p->nav, lever, rate);
    std::array<double, NavErrors::kCount> error;
    error.fill(kNan);
    const Eigen::Vector3d position = ned_from_geodetic(e.position, truth.position);
    const Eigen::Vector3d velocity = e.velocity_ned_mps - truth.velocity_ned_mps;
    const Eigen::Vector3d angles = roll_pitch_yaw_rad(e.q_nb);
    for (Eigen::Index k = 0; k < 3; ++k) {
      error[static_cast<std::size_t>(k)] = position[k];
      if (recording.truth_has_velocity) error[static_cast<std::size_t>(k) + 3] = velocity[k];
    }
    if (recording.truth_has_attitude) {
      const Eigen::Vector3d true_angles = roll_pitch_yaw_rad(truth.q_nb);
      for (Eigen::Index k = 0; k < 3; ++k)
        error[static_cast<std::size_t>(k) + 6] = wrapped_deg(angles[k] - true_angles[k]);
    } else if (recording.truth_has_velocity &&
               truth.velocity_ned_mps.head<2>().norm() > kCourseSpeed_mps) {
      error[8] = wrapped_deg(angles[2] -
                             std::atan2(truth.velocity_ned_mps.y(), truth.velocity_ned_mps.x()));
    }
    result.time_s.push_back(since_start(recording, truth.time));
    for (std::size_t k = 0; k < NavErrors::kCount; ++k) {
      const double sigma = p->sigma[static_cast<Eigen::Index>(k)];
      result.error[k].push_back(error[k]);
      result.sigma[k].push_back(k < 6 ? sigma : sigma / kDegree);
    }
  }
  return result;
}

PlainGnss plain_gnss(const NavRecording& recording) {
  PlainGnss plain;
  const auto add = [&](LogTime time, const Geodetic& position) {
    const auto truth = reference_at(recording.truth, recording.truth_has_velocity, time);
    plain.time_s.push_back(since_start(recording, time));
    plain.position.push_back(position);
    plain.error_ned_m.push_back(truth ? ned_from_geodetic(position, truth->position)
                                      : Eigen::Vector3d::Constant(kNan).eval());
  };
  Eigen::Vector3d near = Eigen::Vector3d::Zero();
  for (const RangeEpoch& epoch : recording.recording.ranges) {
    const auto point = single_point(epoch, {}, near);
    if (!point) continue;
    near = point->position_ecef_m;
    add(epoch.time, point->position);
  }
  if (recording.recording.ranges.empty())
    for (const GnssFix& fix : recording.recording.fixes) add(fix.time, fix.position);
  return plain;
}

}  // namespace wayfare::examples
