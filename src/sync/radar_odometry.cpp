#include <wayfare/sync/radar_odometry.hpp>

#include <algorithm>
#include <cmath>
#include <deque>
#include <optional>
#include <utility>

#include <Eigen/Core>

#include <wayfare/core/random.hpp>
#include <wayfare/sync/odometry_track.hpp>

namespace wayfare {
namespace {

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

/// Ratio of the radar's speed to that of wheels that roll: a random walk, by a scalar Kalman
/// filter.
class RadarScale {
 public:
  explicit RadarScale(const RadarOdometryOptions& o)
      : variance_(o.scale_sigma * o.scale_sigma),
        walk_(o.scale_walk_per_sqrt_s * o.scale_walk_per_sqrt_s) {}

  void update(const ForwardSpeed& wheels, const ForwardSpeed& radar, double dt_s) {
    variance_ += walk_ * dt_s;
    const double wheels_m_s = wheels.m_s;
    const double gain =
        variance_ * wheels_m_s /
        (variance_ * wheels_m_s * wheels_m_s + radar.variance + value_ * value_ * wheels.variance);
    value_ += gain * (radar.m_s - value_ * wheels_m_s);
    variance_ *= 1.0 - gain * wheels_m_s;
  }
  /// The speed on the wheels' scale.
  [[nodiscard]] ForwardSpeed corrected(const ForwardSpeed& radar) const {
    return {radar.m_s / value_, radar.variance / (value_ * value_)};
  }
  [[nodiscard]] double value() const { return value_; }
  [[nodiscard]] double sigma() const { return std::sqrt(variance_); }

 private:
  double value_ = 1.0, variance_, walk_;
};

/// Walks through the intervals of a recording.
class RadarOdometer {
 public:
  RadarOdometer(const Recording& recording, const RadarOdometryOptions& options)
      : o_(options),
        gyro_(recording.gyro),
        speeds_(recording.radar, recording.T_base_radar.raw(), options),
        slip_(options),
        scale_(options) {
    out_.wheel_base_m =
        recording.wheel_base_m > 0.0 ? recording.wheel_base_m : options.wheel_base_m;
    out_.frames = recording.radar.size();
    out_.frames_without = recording.radar.size() - speeds_.size();
  }

  /// The wheels are known from the last time to this one.
  void rolled(const WheelSample& w) {
    const double dt = to_seconds(w.time - last_);
    if (!(dt > 0.0)) return;
    Interval now{out_.wheels.size(),
                 w.time,
                 dt,
                 0.5 * (w.left_m + w.right_m),
                 (w.right_m - w.left_m) / out_.wheel_base_m,
                 gyro_rate(w.time, dt),
                 {}};
    now.radar = speeds_.over(last_, w.time, now.gyro_rad_s.value_or(now.turn / dt));
    believe_before(w.time);
    append(w.time, now.along_m, now.turn);
    recent_.push_back(now);
    const auto radar = now.radar ? std::optional(scale_.corrected(*now.radar)) : std::nullopt;
    if (!slip_.add(now.along_m / dt, radar, now.turn / dt, now.gyro_rad_s, dt)) return;
    // Slip began before it was noticed.
    for (const Interval& interval : recent_) replace(interval);
    recent_.clear();
  }
  /// They are not: samples up to `time`, by radar and gyro.
  void silent_until(LogTime time) {
    const Duration period = from_seconds(o_.period_s);
    while (last_ < time) {
      const LogTime to = std::min(last_ + period, time);
      const double dt = to_seconds(to - last_), rate = gyro_rate(to, dt).value_or(0.0);
      const auto radar = speeds_.over(last_, to, rate);
      (radar ? out_.silent_s : out_.unknown_s) += dt;
      append(to, (radar ? scale_.corrected(*radar).m_s : speed_m_s_) * dt, rate * dt);
    }
  }
  void begin(LogTime time) {
    last_ = time;
    out_.wheels.push_back({time, 0.0, 0.0});
  }
  [[nodiscard]] LogTime last() const { return last_; }
  [[nodiscard]] RadarOdometry take() {
    out_.radar_scale = scale_.value();
    out_.radar_scale_sigma = scale_.sigma();
    return std::move(out_);
  }

 private:
  /// Between two samples of the wheels.
  struct Interval {
    std::size_t sample;  ///< of the output, at its end
    LogTime end;
    double dt_s, along_m, turn;  ///< by the wheels
    std::optional<double> gyro_rad_s;
    std::optional<ForwardSpeed> radar;
  };

  [[nodiscard]] std::optional<double> gyro_rate(LogTime to, double dt) const {
    const auto turned = gyro_.between(last_, to);
    return turned ? std::optional(turned->radians() / dt) : std::nullopt;
  }
  /// Wheels that were not found to slip in the time in which it would be noticed rolled.
  void believe_before(LogTime time) {
    while (!recent_.empty() && to_seconds(time - recent_.front().end) > 2.0 * o_.slip_time_s) {
      const Interval& i = recent_.front();
      const double variance_m2 =
          0.5 * o_.wheel_noise_m_per_sqrt_m * o_.wheel_noise_m_per_sqrt_m * std::abs(i.along_m);
      const ForwardSpeed wheels{i.along_m / i.dt_s, variance_m2 / (i.dt_s * i.dt_s)};
      if (i.radar) scale_.update(wheels, *i.radar, i.dt_s);
      recent_.pop_front();
    }
  }
  void replace(const Interval& i) {
    if (!i.radar) return;
    out_.slipped_s += i.dt_s;
    speed_m_s_ = scale_.corrected(*i.radar).m_s;
    out_.wheels[i.sample] =
        sample(i.end, speed_m_s_ * i.dt_s, i.gyro_rad_s ? *i.gyro_rad_s * i.dt_s : i.turn);
  }
  [[nodiscard]] WheelSample sample(LogTime time, double along, double turn) const {
    const double half = 0.5 * out_.wheel_base_m * turn;
    return {time, along - half, along + half};
  }
  void append(LogTime time, double along, double turn) {
    speed_m_s_ = along / to_seconds(time - last_);
    out_.wheels.push_back(sample(time, along, turn));
    last_ = time;
  }

  RadarOdometryOptions o_;
  GyroTurn gyro_;
  RadarSpeeds speeds_;
  SlipDetector slip_;
  RadarScale scale_;
  std::deque<Interval> recent_;  ///< of wheels that may yet be found to slip
  RadarOdometry out_;
  LogTime last_;
  double speed_m_s_ = 0.0;
};

}  // namespace

RadarOdometry radar_odometry(const Recording& recording, const RadarOdometryOptions& options) {
  RadarOdometer odometer(recording, options);
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

Recording with_radar_odometry(Recording recording, const RadarOdometryOptions& options) {
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
