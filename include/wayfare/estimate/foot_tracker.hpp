#pragma once

// Where a foot is, from an inertial unit on it: strapdown navigation that is told its velocity
// whenever the foot stands.

#include <algorithm>
#include <cmath>
#include <cstdint>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <wayfare/estimate/ahrs_report.hpp>
#include <wayfare/estimate/foot_filter.hpp>
#include <wayfare/estimate/foot_parameters.hpp>
#include <wayfare/estimate/foot_readings.hpp>
#include <wayfare/estimate/sample_clock.hpp>
#include <wayfare/measure/imu.hpp>
#include <wayfare/measure/recording.hpp>

namespace wayfare {

/// The foot at one reading. World axes: z up, origin where it began, x and y as the sensor stood.
struct FootPose {
  LogTime time;
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d velocity_mps = Eigen::Vector3d::Zero();
  SO3d q_world_foot;
  Eigen::Matrix3d position_covariance_m2 = Eigen::Matrix3d::Zero();
  Angle heading;           ///< turned since the start, about the vertical, counter-clockwise
  double statistic = 0.0;  ///< of standing, by FootParameters::statistic
  double stands = 0.0;     ///< probability given to a stance found here; zero in between

  [[nodiscard]] OdometrySample odometry() const {
    return {time,
            Transform2<frame::Odom, frame::Base>(SE2d(position_m.x(), position_m.y(), heading))};
  }
};

/// What became of the readings, and what went wrong on the way.
struct FootReport {
  SensorReport gyro, accelerometer;
  std::uint64_t stances = 0;  ///< believed more than not
  std::uint64_t doubted = 0;  ///< quiet, but against the filter's own velocity
  std::uint64_t gaps = 0;     ///< pauses that left the velocity unknown
  std::uint64_t lost = 0;     ///< times velocity or attitude was taken anew
};

/// Causal, with a delay: what add() is given comes out stance_apart_s and half the window later.
class FootTracker {
 public:
  explicit FootTracker(const FootParameters& parameters = {})
      : p_(parameters), readings_(parameters) {}

  /// Takes a reading and hands those that are due to `sink(const FootPose&)`. Both sensors must
  /// have given something; what cannot be used leaves the state as it was.
  template <class Sink>
  Intake add(const ImuSample& sample, Sink&& sink) {
    const Intake intake = judge(sample);
    if (intake != Intake::used && intake != Intake::saturated) return intake;
    if (broken_off_) finish(sink);
    broken_off_ = false;
    readings_.add(sample);
    hand_out(sink);
    return intake;
  }
  Intake add(const ImuSample& sample) {
    return add(sample, [](const FootPose&) {});
  }
  /// Hands out what was waiting for later readings: at the end of a recording.
  template <class Sink>
  void finish(Sink&& sink) {
    readings_.close();
    hand_out(sink);
    readings_.clear();
  }

  [[nodiscard]] bool ready() const { return ready_; }
  /// As handed out last.
  [[nodiscard]] const FootPose& pose() const { return pose_; }
  [[nodiscard]] const FootFilter& filter() const { return filter_; }
  [[nodiscard]] FootFilter& filter() { return filter_; }
  [[nodiscard]] const FootReport& report() const { return report_; }

 private:
  using Vector = Eigen::Vector3d;
  static constexpr double kPatience_s = 1.0;

  Intake judge(const ImuSample& s) {
    const double rate = s.angular_rate_radps.cwiseAbs().maxCoeff();
    const double force = s.specific_force_mps2.cwiseAbs().maxCoeff();
    const bool has_rate = s.angular_rate_radps.allFinite();
    const bool has_force = s.specific_force_mps2.allFinite();
    const auto verdict = [](bool has, double reading, double range) {
      return !has ? Intake::missing : reading >= range ? Intake::saturated : Intake::used;
    };
    Intake gyro = verdict(has_rate, rate, p_.rate_range);
    Intake accelerometer = verdict(has_force, force, p_.force_range);
    Intake both = !has_rate || !has_force ? Intake::missing
                  : gyro != Intake::used  ? gyro
                                          : accelerometer;
    // What lies far outside the range was not measured.
    const bool absurd = rate > 4.0 * p_.rate_range || force > 4.0 * p_.force_range;
    if (both != Intake::missing && !absurd) {
      const auto when = clock_.check(s.time);
      if (when == SampleClock::Verdict::late) gyro = accelerometer = both = Intake::late;
      if (when == SampleClock::Verdict::first) broken_off_ = true;
    } else if (absurd) {
      both = Intake::missing;
    }
    report_.gyro.note(gyro);
    report_.accelerometer.note(accelerometer);
    return both;
  }

  template <class Sink>
  void hand_out(Sink&& sink) {
    FootReadings::Entry entry;
    while (readings_.next(entry)) {
      step(entry);
      if (!ready_) continue;
      write_pose(entry);
      sink(static_cast<const FootPose&>(pose_));
    }
  }

  void step(const FootReadings::Entry& e) {
    stands_ = 0.0;
    const double dt = has_last_ ? to_seconds(e.time - last_.time) : 0.0;
    if (!ready_) {
      start(e);
    } else if (!(dt > 0.0) || dt > p_.longest_gap_s) {
      bridge(dt > 0.0 ? dt : kPatience_s);
    } else {
      filter_.predict(e.angular_rate_radps, e.specific_force_mps2, p_.gravity_mps2, dt);
      filter_.add_noise(noise(e, dt));
      since_stance_s_ += dt;
      if (e.stillest) use_stance(e);
      use_rest(e, dt);
    }
    last_ = e;
    has_last_ = true;
  }

  /// At the first stillest reading whose force could be gravity.
  void start(const FootReadings::Entry& e) {
    const double norm = e.specific_force_mps2.norm();
    if (!(std::abs(norm - p_.gravity_mps2) < 0.5 * p_.gravity_mps2)) return;
    level(e, e.statistic < p_.quiet_statistic);
    filter_.set_position(Vector::Zero(), 0.0);
    filter_.set_bias_variances(p_.rate_bias_sigma * p_.rate_bias_sigma,
                               p_.force_bias_sigma * p_.force_bias_sigma);
    q_start_ = filter_.q_world_foot();
    ready_ = true;
  }

  /// Takes velocity and tilt from a reading; the heading stays, for it would be lost.
  void level(const FootReadings::Entry& e, bool quiet) {
    const SO3d& q = filter_.q_world_foot();
    const Vector up = q * e.specific_force_mps2;
    const SO3d upright = SO3d::between(up, Vector::UnitZ());
    const double tilt = quiet ? p_.start_tilt_sigma : 10.0 * p_.start_tilt_sigma;
    const double heading2 = filter_.covariance()(8, 8);
    filter_.set_attitude(upright * q, {tilt * tilt, tilt * tilt, heading2});
    const double speed = quiet ? p_.stance_speed : p_.stance_speed_limit;
    filter_.set_velocity(Vector::Zero(), speed * speed);
    since_stance_s_ = 0.0;
    rest_s_ = 0.0;
  }

  void bridge(double gap_s) {
    ++report_.gaps;
    constexpr double kSpeed = 2.0, kTurn = 1.0;  // m/s and rad/s nobody saw
    filter_.set_velocity(Vector::Zero(), kSpeed * kSpeed);
    FootFilter::Noise n;
    n.position = std::pow(kSpeed * gap_s, 2);
    n.angle = std::pow(std::min(kTurn * gap_s, 1.0), 2);
    filter_.add_noise(n);
    rest_s_ = 0.0;
  }

  [[nodiscard]] FootFilter::Noise noise(const FootReadings::Entry& e, double dt) {
    const auto square = [](double x) { return x * x; };
    const Vector& w = e.angular_rate_radps;
    const double a = e.specific_force_mps2.norm() - p_.gravity_mps2;
    const double jump = (e.specific_force_mps2 - last_.specific_force_mps2).squaredNorm();
    const double turn_jump = (w - last_.angular_rate_radps).squaredNorm();
    FootFilter::Noise n;
    n.velocity = (square(p_.force_noise) + square(p_.force_scale_noise * a)) * dt +
                 square(p_.force_jump_noise * dt) * jump;
    if (e.specific_force_mps2.cwiseAbs().maxCoeff() >= p_.force_range)
      n.velocity += square(p_.saturated_part * p_.force_range * dt);
    n.angle = (square(p_.rate_noise) + square(p_.rate_scale_noise) * w.squaredNorm()) * dt +
              square(p_.rate_jump_noise * dt) * turn_jump;
    n.rate_bias = square(p_.rate_bias_walk) * dt;
    n.force_bias = square(p_.force_bias_walk) * dt;
    n.missed_turn = missed_turn(w, dt);
    return n;
  }

  /// A saturated axis misses a turn in one direction all the time: the deviation grows, not the
  /// variance.
  [[nodiscard]] Eigen::Matrix3d missed_turn(const Vector& w, double dt) {
    Vector missed = Vector::Zero();
    for (int i = 0; i < 3; ++i)
      if (std::abs(w[i]) >= p_.rate_range) missed[i] = p_.saturated_part * w[i] * dt;
    if (missed.isZero(0.0)) {
      missed_.setZero();
      return Eigen::Matrix3d::Zero();
    }
    const Vector now = filter_.q_world_foot() * missed;
    const double before = missed_.norm();
    missed_ += now;
    // (b + n)² − b² along n.
    return (1.0 + 2.0 * before / now.norm()) * now * now.transpose();
  }

  void use_stance(const FootReadings::Entry& e) {
    const double variance = p_.stance_speed * p_.stance_speed * (1.0 + e.statistic);
    if (!(variance < p_.stance_speed_limit * p_.stance_speed_limit)) return;
    const double quiet = std::max(1.0, p_.quiet_statistic / std::max(e.statistic, 1e-6));
    stands_ = filter_.stand_or_move(variance, p_.moving_speed * p_.moving_speed,
                                    p_.quiet_power * std::log(quiet));
    if (stands_ > 0.5) {
      ++report_.stances;
      since_stance_s_ = 0.0;
      hold_height();
      return;
    }
    ++report_.doubted;
    if (since_stance_s_ < p_.lost_after_s) return;
    ++report_.lost;
    level(e, e.statistic < p_.rest_statistic);
  }

  void hold_height() {
    const double z = filter_.position().z();
    if (has_height_ && std::abs(z - height_m_) < p_.level_step_m)
      filter_.observe_along(Vector::UnitZ(), height_m_, p_.level_sigma_m * p_.level_sigma_m);
    height_m_ = filter_.position().z();
    has_height_ = true;
  }

  void use_rest(const FootReadings::Entry& e, double dt) {
    if (!(e.statistic < p_.rest_statistic)) {
      rest_s_ = sum_s_ = 0.0;
      return;
    }
    constexpr double kMean_s = 0.1;
    rest_s_ += dt;
    if (sum_s_ <= 0.0) rate_sum_.setZero();
    rate_sum_ += e.angular_rate_radps * dt;
    sum_s_ += dt;
    if (sum_s_ < kMean_s) return;
    if (rest_s_ > p_.rest_time_s)
      filter_.observe<FootFilter::kRateBias>(rate_sum_ / sum_s_,
                                             p_.rest_rate_sigma * p_.rest_rate_sigma);
    sum_s_ = 0.0;
  }

  void write_pose(const FootReadings::Entry& e) {
    const Eigen::Quaterniond turned = (filter_.q_world_foot() * q_start_.inverse()).quaternion();
    pose_ = {e.time,
             filter_.position(),
             filter_.velocity(),
             filter_.q_world_foot(),
             filter_.covariance().topLeftCorner<3, 3>(),
             Angle::radians(2.0 * std::atan2(turned.z(), turned.w())).wrapped(),
             e.statistic,
             stands_};
  }

  FootParameters p_;
  FootReadings readings_;
  FootFilter filter_;
  SampleClock clock_{kPatience_s};
  ImuSample last_;
  FootPose pose_;
  FootReport report_;
  SO3d q_start_;
  Vector missed_ = Vector::Zero(), rate_sum_ = Vector::Zero();
  double since_stance_s_ = 0.0, rest_s_ = 0.0, sum_s_ = 0.0, height_m_ = 0.0, stands_ = 0.0;
  bool ready_ = false, has_last_ = false, has_height_ = false, broken_off_ = false;
};

}  // namespace wayfare
