#pragma once

// Starts without velocities: at rest with an unknown heading, and on a straight by successive
// positions.

#include <algorithm>
#include <cmath>
#include <deque>
#include <numbers>
#include <optional>

#include <Eigen/Core>

#include <wayfare/nav/gnss_ins.hpp>

#include "nav/gnss_ins/zero_velocity_detector.hpp"

namespace wayfare::nav {

/// Above this standard deviation a heading is unknown: equations linear in its error do not hold.
inline constexpr double kUnknownHeading_rad = 1.0;
/// Of a heading about which nothing is known.
inline constexpr double kNoHeadingSigma_rad = std::numbers::pi / std::numbers::sqrt3;

/// Standard deviations of a receiver's position that a start has. The first measurements of the
/// filter have the errors of that position: where they are correlated it must not count twice.
[[nodiscard]] inline double sigmas_of_start(const GnssInsOptions& options) {
  return options.correlated.share > 0.0 ? 10.0 : 2.0;
}

struct StartPosition {
  LogTime time;
  Geodetic antenna;
  double sigma_m = 0.0;
  std::optional<Eigen::Vector3d> velocity_ned_mps;
};

class CoarseStarter {
 public:
  explicit CoarseStarter(const GnssInsOptions& options) : options_(options) {}

  void add(const ImuSample& s) {
    const double dt = last_ ? std::min(to_seconds(s.time - *last_), 1.0) : 0.0;
    last_ = s.time;
    recent_.add(s, dt);
    const Eigen::Vector3d force = recent_.mean_force_mps2();
    if (force.norm() > 0.1) heading_rad_ -= dt * s.angular_rate_radps.dot(force.normalized());
    const bool calm = recent_.full() && recent_.force_spread_mps2() < 0.3 &&
                      recent_.rate_spread_radps() < 0.06 && recent_.mean_rate_radps().norm() < 0.05;
    calm_s_ = calm ? calm_s_ + dt : 0.0;
  }

  /// `may_rest`: also a start at rest.
  [[nodiscard]] std::optional<GnssInsStart> add(const StartPosition& p, bool may_rest) {
    if (!recent_.full() || !last_ || std::abs(to_seconds(p.time - *last_)) > 1.0)
      return std::nullopt;
    if (track_.empty()) origin_ = p.antenna;
    track_.push_back({p.time, ned_from_geodetic(p.antenna, origin_), heading_rad_});
    sigma_m_ = std::max(p.sigma_m, 0.01);
    while (to_seconds(p.time - track_.front().time) > kLongest_s) track_.pop_front();
    // The longest straight that ends here.
    for (std::size_t first = 0; first + 4 <= track_.size(); ++first) {
      const auto slope = fit_slope(first);
      if (!slope || slope->span_s < kShortest_s) break;
      if (const auto moving = moving_start(p, *slope)) return moving;
    }
    const auto slope = fit_slope(0);
    if (!slope) return std::nullopt;
    const bool stands = slope->span_s > 0.6 * kLongest_s && calm_s_ > kRest_s &&
                        (!p.velocity_ned_mps || p.velocity_ned_mps->norm() < 0.5) &&
                        slope->mps.norm() < std::max(0.5, 3.0 * slope->sigma_mps);
    return may_rest && stands ? std::optional(rest_start(p)) : std::nullopt;
  }

 private:
  static constexpr double kLongest_s = 10.0, kShortest_s = 2.5, kRest_s = 3.0;

  struct Place {
    LogTime time;
    Eigen::Vector3d ned_m;
    double heading_rad;  ///< by the gyros, since the first reading
  };
  struct Slope {
    Eigen::Vector3d mps = Eigen::Vector3d::Zero();
    double sigma_mps = 0.0, span_s = 0.0;
    double turn_rad = 0.0;        ///< largest change of heading within
    double turn_after_rad = 0.0;  ///< from the mean to the end
  };

  /// A straight line through the positions from the `first`.
  [[nodiscard]] std::optional<Slope> fit_slope(std::size_t first) const {
    if (track_.size() < first + 4) return std::nullopt;
    const auto begin = track_.begin() + static_cast<std::ptrdiff_t>(first);
    const auto n = static_cast<double>(track_.size() - first);
    const LogTime end = track_.back().time;
    double mean_s = 0.0, mean_heading = 0.0, squares = 0.0, low = 1e9, high = -1e9;
    for (auto p = begin; p != track_.end(); ++p) {
      mean_s += to_seconds(p->time - end) / n, mean_heading += p->heading_rad / n;
      low = std::min(low, p->heading_rad), high = std::max(high, p->heading_rad);
    }
    Slope slope;
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (auto p = begin; p != track_.end(); ++p) {
      const double t = to_seconds(p->time - end) - mean_s;
      squares += t * t, sum += t * p->ned_m;
    }
    if (!(squares > 0.0)) return std::nullopt;
    slope.mps = sum / squares;
    slope.sigma_mps = sigma_m_ / std::sqrt(squares);
    slope.span_s = to_seconds(end - begin->time);
    slope.turn_rad = high - low;
    slope.turn_after_rad = track_.back().heading_rad - mean_heading;
    return slope;
  }

  [[nodiscard]] std::optional<GnssInsStart> moving_start(const StartPosition& p,
                                                         const Slope& slope) const {
    constexpr double kStraight_rad = 0.25, kSpeedChange_mps = 2.0, kSure = 6.0;
    const double speed = slope.mps.head<2>().norm();
    if (speed < std::max(options_.start_speed_mps, kSure * slope.sigma_mps) || speed > 200.0 ||
        slope.turn_rad > kStraight_rad)
      return std::nullopt;
    const double heading = std::atan2(slope.mps.y(), slope.mps.x()) + slope.turn_after_rad;
    GnssInsStart start = level_start(p, heading);
    start.nav.velocity_ned_mps = speed * Eigen::Vector3d(std::cos(heading), std::sin(heading), 0.0);
    start.velocity_sigma_mps = std::hypot(slope.sigma_mps, kSpeedChange_mps);
    start.level_sigma_rad = 0.15;
    start.heading_sigma_rad =
        std::hypot(std::hypot(options_.start_heading_sigma_rad, slope.sigma_mps / speed),
                   0.5 * slope.turn_rad);
    return start;
  }

  [[nodiscard]] GnssInsStart rest_start(const StartPosition& p) const {
    GnssInsStart start = level_start(p, 0.0);
    start.velocity_sigma_mps = 0.3;
    start.level_sigma_rad = 0.03;
    start.heading_sigma_rad = kNoHeadingSigma_rad;
    return start;
  }

  /// Level by gravity: without acceleration but for its standard deviation.
  [[nodiscard]] GnssInsStart level_start(const StartPosition& p, double heading) const {
    const Eigen::Vector3d f = options_.q_body_imu * recent_.mean_force_mps2();
    const double roll = std::atan2(-f.y(), -f.z());
    const double pitch = std::atan2(f.x(), std::hypot(f.y(), f.z()));
    GnssInsStart start;
    start.nav.time = p.time;
    start.nav.q_nb = rotation_from_roll_pitch_yaw({roll, pitch, heading});
    start.nav.position =
        geodetic_from_ned(-(start.nav.q_nb * options_.antenna_lever_arm_m), p.antenna);
    start.position_sigma_m = std::max(1.0, sigmas_of_start(options_) * p.sigma_m) +
                             options_.antenna_lever_arm_m.head<2>().norm();
    return start;
  }

  GnssInsOptions options_;
  RecentReadings recent_;
  std::optional<LogTime> last_;
  double heading_rad_ = 0.0, calm_s_ = 0.0, sigma_m_ = 1.0;
  Geodetic origin_;
  std::deque<Place> track_;
};

}  // namespace wayfare::nav
