#pragma once

// Odometry of a robot on two driven wheels by its wheels, gyro and the radial speeds of a radar's
// frames: wheels that slip are replaced while they do, wheels that are missing all the time.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include <wayfare/core/random.hpp>
#include <wayfare/motion/radar_velocity.hpp>
#include <wayfare/sensors/recording.hpp>
#include <wayfare/sync/odometry_track.hpp>

namespace wayfare {

/// Noise and slip detection of radar_odometry.
struct RadarOdometryOptions {
  /// Of each frame; inliers within two Doppler bins of 0.12 m/s and a bit: fewer bias it.
  RadarVelocityOptions velocity{.plane = true, .inlier_m_s = 0.3};
  /// Standard deviation of each wheel's distance after one metre without slipping.
  double wheel_noise_m_per_sqrt_m = 0.006;
  double side_sigma_m_s = 0.01;  ///< standard deviation of the base's speed to the side, m/s
  double longest_hold_s = 0.3;   ///< how long a velocity is used without another frame
  double largest_gap_s = 0.3;    ///< between wheel samples further apart they are silent
  double period_s = 0.05;        ///< of the samples where there are no wheels
  double wheel_base_m = 0.4;     ///< where the recording has none
  /// Wheels slip where the mean difference of their speed to the radar's, over about `slip_time_s`,
  /// exceeds `slip_sigmas` standard deviations, a share of the speed and a constant together; or
  /// that of their turn rate to the gyro's. Larger: fewer false alarms, slip believed for longer.
  double slip_time_s = 0.4;
  double slip_sigmas = 4.0;       ///< of the mean difference
  double slip_share = 0.08;       ///< of the wheels' speed or turn rate
  double slip_m_s = 0.01;         ///< m/s
  double slip_turn_rad_s = 0.08;  ///< rad/s
};

/// Distances rolled, and how they were found.
struct RadarOdometry {
  /// As if rolled without slip on wheels `wheel_base_m` apart.
  std::vector<WheelSample> wheels;
  double wheel_base_m = 0.0;  ///< of the recording, or of the options
  std::size_t frames = 0,     ///< of the radar
      frames_without = 0;     ///< of these without a velocity
  double slipped_s = 0.0,     ///< time in which slipping wheels were replaced
      silent_s = 0.0,         ///< time in which missing wheels were replaced
      unknown_s = 0.0;        ///< time without wheels and radar: speed kept
};

namespace detail {

/// Mean forward speed over an interval, with the variance of an error independent of other
/// intervals'.
struct ForwardSpeed {
  double m_s = 0.0, variance = 0.0;
};

/// Forward speed of the base by the radar's frames, of a robot that does not slide to the side.
class RadarSpeeds {
 public:
  RadarSpeeds(const std::vector<RadarScan>& scans, const SE2d& T_base_radar,
              const RadarOdometryOptions& options)
      : options_(options), T_base_radar_(T_base_radar) {
    const Rng rng(1);
    for (std::size_t i = 0; i < scans.size(); ++i) {
      const auto v = radar_velocity(scans[i], rng.stream(i), options_.velocity);
      if (!v) continue;
      frames_.push_back({v->time, v->velocity_m_s.head<2>(), v->covariance.topLeftCorner<2, 2>()});
    }
  }
  [[nodiscard]] std::size_t size() const { return frames_.size(); }

  /// Of the frames in (from, to], else of the last one if it is recent. The turn rate acts at the
  /// lever arm. To be called in order of time.
  [[nodiscard]] std::optional<ForwardSpeed> over(LogTime from, LogTime to, double turn_rate_rad_s) {
    while (first_ < frames_.size() && frames_[first_].time <= from) ++first_;
    double weights = 0.0, sum = 0.0;
    for (std::size_t i = first_; i < frames_.size() && frames_[i].time <= to; ++i) {
      const ForwardSpeed s = forward(frames_[i], turn_rate_rad_s);
      weights += 1.0 / s.variance, sum += s.m_s / s.variance;
    }
    if (weights > 0.0) return ForwardSpeed{sum / weights, 1.0 / weights};
    if (first_ == 0 || to_seconds(to - frames_[first_ - 1].time) > options_.longest_hold_s)
      return std::nullopt;
    // A frame used before is no new information.
    constexpr double kHeld = 10.0;
    const ForwardSpeed held = forward(frames_[first_ - 1], turn_rate_rad_s);
    return ForwardSpeed{held.m_s, kHeld * held.variance};
  }

 private:
  struct Frame {
    LogTime time;
    Eigen::Vector2d velocity_m_s;
    Eigen::Matrix2d covariance;
  };
  /// Given that the base's velocity to the side is about zero.
  [[nodiscard]] ForwardSpeed forward(const Frame& f, double turn_rate_rad_s) const {
    const Eigen::Matrix2d r = T_base_radar_.rotation().matrix();
    const Eigen::Vector2d& lever = T_base_radar_.translation();
    const Eigen::Vector2d v =
        r * f.velocity_m_s - turn_rate_rad_s * Eigen::Vector2d(-lever.y(), lever.x());
    const Eigen::Matrix2d c = r * f.covariance * r.transpose();
    const double gain = c(0, 1) / (c(1, 1) + options_.side_sigma_m_s * options_.side_sigma_m_s);
    return {v.x() - gain * v.y(), std::max(c(0, 0) - gain * c(0, 1), 1e-8)};
  }

  RadarOdometryOptions options_;
  SE2d T_base_radar_;
  std::vector<Frame> frames_;
  std::size_t first_ = 0;
};

/// Whether wheels differ from radar and gyro for longer than noise explains.
class SlipDetector {
 public:
  explicit SlipDetector(const RadarOdometryOptions& options) : o_(options) {}

  bool add(double wheels_m_s, const std::optional<ForwardSpeed>& radar, double wheels_rad_s,
           const std::optional<double>& gyro_rad_s, double dt_s) {
    const double keep = std::exp(-dt_s / o_.slip_time_s), take = 1.0 - keep;
    if (radar) {
      speed_ = keep * speed_ + take * (wheels_m_s - radar->m_s);
      variance_ = keep * keep * variance_ + take * take * radar->variance;
    }
    if (gyro_rad_s) turn_ = keep * turn_ + take * (wheels_rad_s - *gyro_rad_s);
    const double factor = slips_ ? 0.5 : 1.0;
    const double speed =
        o_.slip_sigmas * std::sqrt(variance_) + o_.slip_share * std::abs(wheels_m_s) + o_.slip_m_s;
    const double turn = o_.slip_share * std::abs(wheels_rad_s) + o_.slip_turn_rad_s;
    slips_ = radar &&
             (std::abs(speed_) > factor * speed || (gyro_rad_s && std::abs(turn_) > factor * turn));
    return slips_;
  }

 private:
  RadarOdometryOptions o_;
  double speed_ = 0.0, variance_ = 0.0, turn_ = 0.0;
  bool slips_ = false;
};

/// Walks through the intervals of a recording.
class RadarOdometer {
 public:
  RadarOdometer(const Recording& recording, const RadarOdometryOptions& options)
      : o_(options),
        gyro_(recording.gyro),
        speeds_(recording.radar, recording.T_base_radar.raw(), options),
        slip_(options) {
    out_.wheel_base_m =
        recording.wheel_base_m > 0.0 ? recording.wheel_base_m : options.wheel_base_m;
    out_.frames = recording.radar.size();
    out_.frames_without = recording.radar.size() - speeds_.size();
  }

  /// The wheels are known from the last time to this one.
  void rolled(const WheelSample& w) {
    const double dt = to_seconds(w.time - last_);
    if (!(dt > 0.0)) return;
    const double along = 0.5 * (w.left_m + w.right_m);
    const double turn = (w.right_m - w.left_m) / out_.wheel_base_m;
    const auto gyro = gyro_rate(w.time, dt);
    const auto radar = speeds_.over(last_, w.time, gyro.value_or(turn / dt));
    if (slip_.add(along / dt, radar, turn / dt, gyro, dt)) {
      out_.slipped_s += dt;
      return append(w.time, radar->m_s * dt, gyro ? *gyro * dt : turn);
    }
    append(w.time, radar ? fused(along, *radar, dt) : along, turn);
  }
  /// They are not: samples up to `time`, by radar and gyro.
  void silent_until(LogTime time) {
    const Duration period = from_seconds(o_.period_s);
    while (last_ < time) {
      const LogTime to = std::min(last_ + period, time);
      const double dt = to_seconds(to - last_), rate = gyro_rate(to, dt).value_or(0.0);
      const auto radar = speeds_.over(last_, to, rate);
      (radar ? out_.silent_s : out_.unknown_s) += dt;
      append(to, (radar ? radar->m_s : speed_m_s_) * dt, rate * dt);
    }
  }
  void begin(LogTime time) {
    last_ = time;
    out_.wheels.push_back({time, 0.0, 0.0});
  }
  [[nodiscard]] LogTime last() const { return last_; }
  [[nodiscard]] RadarOdometry take() { return std::move(out_); }

 private:
  [[nodiscard]] std::optional<double> gyro_rate(LogTime to, double dt) const {
    const auto turned = gyro_.between(last_, to);
    return turned ? std::optional(turned->radians() / dt) : std::nullopt;
  }
  /// Weighted by the variances of both.
  [[nodiscard]] double fused(double along, const ForwardSpeed& radar, double dt) const {
    const double wheels =
        0.5 * o_.wheel_noise_m_per_sqrt_m * o_.wheel_noise_m_per_sqrt_m * std::abs(along);
    const double gain = wheels / (wheels + radar.variance * dt * dt);
    return along + gain * (radar.m_s * dt - along);
  }
  void append(LogTime time, double along, double turn) {
    const double half = 0.5 * out_.wheel_base_m * turn;
    speed_m_s_ = along / to_seconds(time - last_);
    out_.wheels.push_back({time, along - half, along + half});
    last_ = time;
  }

  RadarOdometryOptions o_;
  GyroTurn gyro_;
  RadarSpeeds speeds_;
  SlipDetector slip_;
  RadarOdometry out_;
  LogTime last_;
  double speed_m_s_ = 0.0;
};

}  // namespace detail

/// Wheels of the recording, corrected and completed by its radar and gyro; of the mounting and
/// wheel base in the recording. A distance depends on measurements up to its time only. Samples
/// that are not finite count as missing. Without radar the wheels as they are.
[[nodiscard]] inline RadarOdometry radar_odometry(const Recording& recording,
                                                  const RadarOdometryOptions& options = {}) {
  detail::RadarOdometer odometer(recording, options);
  std::optional<LogTime> first, last;
  const auto include = [&](const auto& stream) {
    if (stream.empty()) return;
    first = std::min(first.value_or(stream.front().time), stream.front().time);
    last = std::max(last.value_or(stream.back().time), stream.back().time);
  };
  include(recording.wheels), include(recording.radar);
  if (!first) return odometer.take();
  odometer.begin(*first);
  const double gap_s = options.largest_gap_s;
  for (const WheelSample& w : recording.wheels) {
    if (w.time <= odometer.last() || !std::isfinite(w.left_m) || !std::isfinite(w.right_m))
      continue;
    if (to_seconds(w.time - odometer.last()) > gap_s) {
      odometer.silent_until(w.time);
    } else {
      odometer.rolled(w);
    }
  }
  odometer.silent_until(*last);
  return odometer.take();
}

/// `recording` with these wheels, and odometry from them with the gyro's heading where there is
/// one: for any system that uses wheels or odometry.
[[nodiscard]] inline Recording with_radar_odometry(Recording recording,
                                                   const RadarOdometryOptions& options = {}) {
  RadarOdometry found = radar_odometry(recording, options);
  recording.wheel_base_m = found.wheel_base_m;
  recording.wheels = std::move(found.wheels);
  recording.odometry.clear();
  const GyroTurn gyro(recording.gyro);
  SE2d pose;
  for (std::size_t i = 0; i < recording.wheels.size(); ++i) {
    const WheelSample& w = recording.wheels[i];
    if (i > 0) {
      const auto turn = gyro.between(recording.wheels[i - 1].time, w.time);
      const double by_wheels = (w.right_m - w.left_m) / recording.wheel_base_m;
      pose = pose.plus({0.5 * (w.left_m + w.right_m), 0.0, turn ? turn->radians() : by_wheels});
    }
    recording.odometry.push_back({w.time, Transform2<frame::Odom, frame::Base>(pose)});
  }
  return recording;
}

}  // namespace wayfare
