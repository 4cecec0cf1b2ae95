#pragma once

// Errors of navigation solutions.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <functional>
#include <limits>
#include <numbers>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include <wayfare/core/se3.hpp>
#include <wayfare/eval/table.hpp>
#include <wayfare/gnss/single_point.hpp>
#include <wayfare/nav/gnss_ins.hpp>
#include <wayfare/nav/outage.hpp>
#include <wayfare/sensors/trajectory.hpp>

namespace wayfare::eval {

/// Truth minus estimate.
struct NavError {
  Eigen::Vector3d position_ned_m = Eigen::Vector3d::Zero();     ///< north, east, down, m
  Eigen::Vector3d velocity_ned_mps = Eigen::Vector3d::Zero();   ///< north, east, down, m/s
  Eigen::Vector3d attitude_body_rad = Eigen::Vector3d::Zero();  ///< rotation vector
};

/// Errors of an estimate of the same time.
[[nodiscard]] inline NavError nav_error(const NavState& estimate, const NavState& truth) {
  return {ned_from_geodetic(truth.position, estimate.position),
          truth.velocity_ned_mps - estimate.velocity_ned_mps, truth.q_nb.minus(estimate.q_nb)};
}

/// A reference trajectory, in order of time.
struct NavReference {
  NavTrajectory states;       ///< positions at least
  bool has_velocity = false;  ///< whether velocities are known
  bool has_attitude = false;  ///< whether attitudes are known
};

namespace detail {

/// The last state not after `time`; nothing outside of the states.
template <class State, class TimeOf>
[[nodiscard]] std::optional<std::size_t> index_before(const std::vector<State>& states,
                                                      LogTime time, TimeOf time_of) {
  const auto after =
      std::upper_bound(states.begin(), states.end(), time,
                       [&](LogTime t, const State& s) { return t < std::invoke(time_of, s); });
  if (after == states.begin()) return std::nullopt;
  const auto i = static_cast<std::size_t>(after - states.begin()) - 1;
  if (after == states.end() && std::invoke(time_of, states[i]) != time) return std::nullopt;
  return i;
}

[[nodiscard]] inline NavState between(const NavState& a, const NavState& b, double k, bool cubic,
                                      double h_s) {
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

}  // namespace detail

/// The reference interpolated between its states: cubic with velocities, else linear. Nothing
/// outside of it and within gaps of more than 1.5 s.
[[nodiscard]] inline std::optional<NavState> reference_at(const NavReference& reference,
                                                          LogTime time) {
  const auto i = detail::index_before(reference.states, time, &NavState::time);
  if (!i) return std::nullopt;
  const NavState& a = reference.states[*i];
  if (a.time == time) return a;
  const NavState& b = reference.states[*i + 1];
  const double h_s = to_seconds(b.time - a.time);
  if (h_s > 1.5) return std::nullopt;
  return detail::between(a, b, to_seconds(time - a.time) / h_s, reference.has_velocity, h_s);
}

/// The run interpolated between its points; nothing within gaps of more than half a second.
[[nodiscard]] inline std::optional<GnssInsPoint> point_at(const std::vector<GnssInsPoint>& points,
                                                          LogTime time) {
  const auto i =
      detail::index_before(points, time, [](const GnssInsPoint& p) { return p.nav.time; });
  if (!i) return std::nullopt;
  GnssInsPoint p = points[*i];
  if (p.nav.time == time) return p;
  const double h_s = to_seconds(points[*i + 1].nav.time - p.nav.time);
  if (h_s > 0.5) return std::nullopt;
  p.nav =
      detail::between(p.nav, points[*i + 1].nav, to_seconds(time - p.nav.time) / h_s, false, h_s);
  return p;
}

/// The state of a point fixed to the body.
[[nodiscard]] inline NavState at_lever_arm(
    const NavState& unit, const Eigen::Vector3d& lever_arm_m,
    const Eigen::Vector3d& body_rate_radps = Eigen::Vector3d::Zero()) {
  NavState s = unit;
  s.position = geodetic_from_ned(unit.q_nb * lever_arm_m, unit.position);
  s.velocity_ned_mps += unit.q_nb * body_rate_radps.cross(lever_arm_m).eval();
  return s;
}

/// Estimate minus reference over time, and the filter's standard deviation: position and velocity
/// north, east, down (m, m/s), roll, pitch, yaw (degrees). NaN if unknown.
struct NavErrors {
  static constexpr std::size_t kCount = 9;        ///< position, velocity, attitude: three each
  std::vector<double> time_s;                     ///< of each state compared, since `start`
  std::array<std::vector<double>, kCount> error,  ///< estimate minus reference
      sigma;                                      ///< standard deviation of the filter

  /// Horizontal position error of state `i`, m.
  [[nodiscard]] double horizontal(std::size_t i) const {
    return std::hypot(error[0][i], error[1][i]);
  }
};

/// At every state of the reference, whose position is `lever_arm_m` from the unit (body axes);
/// times since `start`. If the reference has no attitude, yaw is compared with its course at speeds
/// above 3 m/s.
[[nodiscard]] inline NavErrors nav_errors(const std::vector<GnssInsPoint>& points,
                                          const NavReference& reference,
                                          const Eigen::Vector3d& lever_arm_m, LogTime start) {
  constexpr double kCourseSpeed_mps = 3.0, kDegree = std::numbers::pi / 180.0;
  const auto wrapped_deg = [](double rad) { return wrap_to_pi(rad) / kDegree; };
  NavErrors result;
  for (const NavState& truth : reference.states) {
    const auto p = point_at(points, truth.time);
    if (!p) continue;
    constexpr Duration kStep = std::chrono::milliseconds(20);
    const auto next = point_at(points, truth.time + kStep);
    Eigen::Vector3d rate = Eigen::Vector3d::Zero();
    if (next) rate = next->nav.q_nb.minus(p->nav.q_nb) / to_seconds(kStep);
    const NavState e = at_lever_arm(p->nav, lever_arm_m, rate);
    const Eigen::Vector3d &v = truth.velocity_ned_mps, angles = roll_pitch_yaw_rad(e.q_nb);
    Eigen::Matrix<double, NavErrors::kCount, 1> error;
    error.setConstant(std::numeric_limits<double>::quiet_NaN());
    error.head<3>() = ned_from_geodetic(e.position, truth.position);
    if (reference.has_velocity) error.segment<3>(3) = e.velocity_ned_mps - v;
    if (reference.has_attitude) {
      error.tail<3>() = (angles - roll_pitch_yaw_rad(truth.q_nb)).unaryExpr(wrapped_deg);
    } else if (reference.has_velocity && v.head<2>().norm() > kCourseSpeed_mps) {
      error[8] = wrapped_deg(angles[2] - std::atan2(v.y(), v.x()));
    }
    result.time_s.push_back(to_seconds(truth.time - start));
    for (std::size_t k = 0; k < NavErrors::kCount; ++k) {
      const auto i = static_cast<Eigen::Index>(k);
      const auto sigma = static_cast<double>(p->sigma[i]);
      result.error[k].push_back(error[i]);
      result.sigma[k].push_back(k < 6 ? sigma : sigma / kDegree);
    }
  }
  return result;
}

/// Single-point position of each epoch, or the fixes.
struct PlainGnss {
  std::vector<double> time_s;                ///< of each epoch or fix
  std::vector<Geodetic> position;            ///< of each epoch or fix
  std::vector<Eigen::Vector3d> error_ned_m;  ///< NaN outside of the reference
};

/// Times since the unit's first sample; without one, since the first epoch or fix.
[[nodiscard]] inline PlainGnss plain_gnss(const GnssInsRecording& recording,
                                          const NavReference& reference) {
  PlainGnss plain;
  LogTime start;
  if (!recording.imu.empty()) {
    start = recording.imu.front().time;
  } else if (!recording.ranges.empty()) {
    start = recording.ranges.front().time;
  } else if (!recording.fixes.empty()) {
    start = recording.fixes.front().time;
  }
  const auto add = [&](LogTime time, const Geodetic& position) {
    const auto truth = reference_at(reference, time);
    plain.time_s.push_back(to_seconds(time - start));
    plain.position.push_back(position);
    plain.error_ned_m.emplace_back(
        Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN()));
    if (truth) plain.error_ned_m.back() = ned_from_geodetic(position, truth->position);
  };
  Eigen::Vector3d near = Eigen::Vector3d::Zero();
  for (const RangeEpoch& epoch : recording.ranges) {
    const auto point = single_point(epoch, {}, near);
    if (!point) continue;
    near = point->position_ecef_m;
    add(epoch.time, point->position);
  }
  if (recording.ranges.empty())
    for (const GnssFix& fix : recording.fixes) add(fix.time, fix.position);
  return plain;
}

/// One row per duration, one column per number of satellites left; `figure` selects the value.
[[nodiscard]] inline Table outage_table(const OutageReport& report, double OutageError::*figure,
                                        int decimals = 2) {
  std::vector<Table::Column> columns = {{"outage", "s"}};
  std::vector<std::vector<std::string>> rows;
  for (const OutageCell& c : report.cells) {
    if (c.duration == report.cells.front().duration)
      columns.push_back({std::to_string(c.satellites_left) +
                             (c.satellites_left == 1 ? " satellite" : " satellites"),
                         "m"});
    const std::string name = fixed(to_seconds(c.duration), 0);
    if (rows.empty() || rows.back().front() != name) rows.push_back({name});
    rows.back().push_back(fixed(c.mean.*figure, decimals));
  }
  Table table(columns);
  for (auto& row : rows) table.add_row(std::move(row));
  return table;
}

}  // namespace wayfare::eval
