#pragma once

// Motion of the antenna by the receiver alone: velocities, and between them accelerations along
// and across the course and the course's rate.

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include <wayfare/core/angle.hpp>
#include <wayfare/core/statistics.hpp>
#include <wayfare/gnss/single_point.hpp>
#include <wayfare/nav/gnss_ins.hpp>

namespace wayfare::nav {

struct TrackPosition {
  double time_s = 0.0;
  Geodetic position;
  double sigma_m = 0.0;
  std::optional<Eigen::Vector3d> velocity_ned_mps;
  double velocity_sigma_mps = 0.0;
};

struct TrackVelocity {
  double time_s = 0.0;
  Eigen::Vector3d ned_mps = Eigen::Vector3d::Zero();
  double sigma_mps = 0.0;
  double span_s = 0.0;  ///< it is the mean over this time
};

/// Means over an interval in which the vehicle moves.
struct TrackInterval {
  double begin_s = 0.0, end_s = 0.0;
  /// Specific force of a body without roll that points along its velocity, forward and right.
  Eigen::Vector2d force_mps2 = Eigen::Vector2d::Zero();
  /// The same without gravity.
  Eigen::Vector2d acceleration_mps2 = Eigen::Vector2d::Zero();
  double course_rate_radps = 0.0;
  double force_sigma_mps2 = 0.0, rate_sigma_radps = 0.0;
};

struct GnssTrack {
  std::vector<TrackPosition> positions;
  std::vector<TrackVelocity> velocities;
  std::vector<TrackInterval> intervals;
  double interval_spacing_s = 1.0;
  std::size_t with_velocity = 0;                            ///< positions with a measured one
  double position_sigma_m = 0.0, velocity_sigma_mps = 0.0;  ///< medians
  double extent_m = 0.0;  ///< nine tenths of the positions are within, about their median
  double fast_mps = 0.0;  ///< nine tenths of the velocities are slower
};

inline void summarise_motion(GnssTrack& track) {
  std::vector<double> sigma, distance, speed, speed_sigma;
  for (const TrackPosition& p : track.positions) sigma.push_back(p.sigma_m);
  if (sigma.empty()) return;
  track.position_sigma_m = upper_median_of(sigma);
  const Geodetic& middle = track.positions[track.positions.size() / 2].position;
  std::vector<double> north, east;
  for (const TrackPosition& p : track.positions) {
    const Eigen::Vector3d ned = ned_from_geodetic(p.position, middle);
    north.push_back(ned.x()), east.push_back(ned.y());
  }
  const double n = median_of(north), e = median_of(east);
  for (std::size_t i = 0; i < north.size(); ++i)
    distance.push_back(std::hypot(north[i] - n, east[i] - e));
  track.extent_m = quantile(distance, 0.9);
  for (const TrackVelocity& v : track.velocities)
    speed.push_back(v.ned_mps.head<2>().norm()), speed_sigma.push_back(v.sigma_mps);
  if (speed.empty()) return;
  track.fast_mps = quantile(speed, 0.9), track.velocity_sigma_mps = upper_median_of(speed_sigma);
}

inline double root_of_largest(const Eigen::Matrix3d& covariance) {
  return std::sqrt(std::max(covariance.diagonal().maxCoeff(), 0.0));
}

inline std::vector<TrackPosition> track_positions(const GnssInsRecording& r, LogTime origin) {
  std::vector<TrackPosition> result;
  const auto seconds = [origin](LogTime t) { return to_seconds(t - origin); };
  if (!r.ranges.empty()) {
    Eigen::Vector3d near = Eigen::Vector3d::Zero();
    for (const RangeEpoch& epoch : r.ranges) {
      const auto p = single_point(epoch, {}, near);
      if (!p) continue;
      near = p->position_ecef_m;
      result.push_back({seconds(epoch.time), p->position,
                        root_of_largest(p->position_covariance_ned_m2), p->velocity_ned_mps,
                        root_of_largest(p->velocity_covariance_ned)});
    }
    return result;
  }
  for (const GnssFix& f : r.fixes) {
    const double sigma = root_of_largest(f.position_covariance_ned_m2);
    const double height = f.position.height_m;
    if (!std::isfinite(sigma) || !(std::abs(height) < 1e6) ||
        !std::isfinite(f.position.latitude.radians() + f.position.longitude.radians()))
      continue;
    const bool moves = f.velocity_ned_mps && f.velocity_ned_mps->allFinite();
    result.push_back({seconds(f.time), f.position, sigma, moves ? f.velocity_ned_mps : std::nullopt,
                      root_of_largest(f.velocity_covariance_ned)});
  }
  return result;
}

inline double median_step_s(const std::vector<TrackPosition>& p) {
  std::vector<double> steps;
  for (std::size_t i = 1; i < p.size(); ++i) steps.push_back(p[i].time_s - p[i - 1].time_s);
  return steps.empty() ? 1.0 : std::max(upper_median_of(steps), 1e-3);
}

/// Measured velocities, or those by differences of positions where they are as good.
inline std::vector<TrackVelocity> track_velocities(const std::vector<TrackPosition>& p) {
  std::vector<TrackVelocity> result;
  if (p.size() < 2) return result;
  std::vector<double> sigmas;
  std::size_t measured = 0;
  for (const TrackPosition& x : p)
    sigmas.push_back(x.sigma_m), measured += x.velocity_ned_mps ? 1 : 0;
  const double step = median_step_s(p), sigma = upper_median_of(sigmas);
  const bool precise = 1.5 * sigma < 0.2 * std::max(step, 0.5);
  if (!precise && 2 * measured > p.size()) {
    for (const TrackPosition& x : p)
      if (x.velocity_ned_mps)
        result.push_back({x.time_s, *x.velocity_ned_mps, std::max(x.velocity_sigma_mps, 0.02)});
    return result;
  }
  const double span = std::clamp(1.5 * sigma / 0.3, std::max(step, 0.2), 8.0);
  for (std::size_t i = 0, k = 0; i < p.size(); ++i) {
    while (k < p.size() && p[k].time_s - p[i].time_s < span - 0.01) ++k;
    if (k == p.size()) break;
    const double dt = p[k].time_s - p[i].time_s;
    if (dt > 2.0 * span + step) continue;
    result.push_back({0.5 * (p[i].time_s + p[k].time_s),
                      ned_from_geodetic(p[k].position, p[i].position) / dt,
                      1.5 * std::max(sigma, 0.005) / dt, dt});
  }
  return result;
}

inline std::optional<TrackInterval> interval_between(const TrackVelocity& a,
                                                     const TrackVelocity& b) {
  constexpr double kSlowest_mps = 0.5, kLargest_mps2 = 8.0, kLargest_radps = 1.5;
  const double dt = b.time_s - a.time_s, sigma = std::max(a.sigma_mps, b.sigma_mps);
  const Eigen::Vector3d v = 0.5 * (a.ned_mps + b.ned_mps);
  const double slow = std::min(a.ned_mps.head<2>().norm(), b.ned_mps.head<2>().norm());
  if (slow < std::max(kSlowest_mps, 4.0 * sigma)) return std::nullopt;
  const Eigen::Vector3d acceleration = (b.ned_mps - a.ned_mps) / dt;
  const double speed = v.head<2>().norm();
  if (acceleration.norm() > kLargest_mps2 || speed < 0.5 * slow || speed > 200.0)
    return std::nullopt;
  const Eigen::Vector3d force =
      acceleration - Eigen::Vector3d(0.0, 0.0, wgs84::kEquatorGravity_mps2);
  const Eigen::Vector3d forward = v.normalized();
  const Eigen::Vector3d right = Eigen::Vector3d(-v.y(), v.x(), 0.0) / speed;
  TrackInterval r;
  // The box of the same spread as the difference of two means.
  const double half_s = 0.5 * std::hypot(dt, std::max(a.span_s, b.span_s));
  r.begin_s = 0.5 * (a.time_s + b.time_s) - half_s;
  r.end_s = 0.5 * (a.time_s + b.time_s) + half_s;
  r.force_mps2 = {force.dot(forward), force.dot(right)};
  r.acceleration_mps2 = {acceleration.dot(forward), acceleration.dot(right)};
  r.course_rate_radps = wrap_to_pi(std::atan2(b.ned_mps.y(), b.ned_mps.x()) -
                                   std::atan2(a.ned_mps.y(), a.ned_mps.x())) /
                        dt;
  if (std::abs(r.course_rate_radps) > kLargest_radps) return std::nullopt;
  r.force_sigma_mps2 = std::hypot(1.4 * sigma / dt, 7.0 * sigma / speed) + 0.05;
  r.rate_sigma_radps = 1.4 * sigma / (slow * dt) + 0.005;
  return r;
}

inline GnssTrack gnss_track(const GnssInsRecording& recording, LogTime origin) {
  constexpr double kSpan_s = 0.75, kLongest_s = 3.0;
  GnssTrack track;
  track.positions = track_positions(recording, origin);
  for (const TrackPosition& p : track.positions) track.with_velocity += p.velocity_ned_mps ? 1 : 0;
  track.velocities = track_velocities(track.positions);
  const auto& v = track.velocities;
  for (std::size_t i = 0, k = 0; i < v.size(); ++i) {
    k = std::max(k, i + 1);
    while (k < v.size() && v[k].time_s - v[i].time_s < kSpan_s) ++k;
    if (k == v.size() || v[k].time_s - v[i].time_s > kLongest_s) continue;
    if (const auto interval = interval_between(v[i], v[k])) track.intervals.push_back(*interval);
  }
  summarise_motion(track);
  track.interval_spacing_s = std::min(median_step_s(track.positions) / kSpan_s, 1.0);
  return track;
}

}  // namespace wayfare::nav
