#pragma once

// Foot-mounted inertial navigation with zero-velocity updates in stance.

#include <algorithm>
#include <cmath>
#include <concepts>

#include <Eigen/Core>

#include <wayfare/core/se3.hpp>
#include <wayfare/inertial/detail/sample_clock.hpp>
#include <wayfare/pedestrian/detail/foot_filter.hpp>
#include <wayfare/pedestrian/detail/foot_noise.hpp>
#include <wayfare/pedestrian/detail/foot_readings.hpp>
#include <wayfare/pedestrian/parameters.hpp>
#include <wayfare/pedestrian/stance.hpp>
#include <wayfare/sensors/measurements.hpp>

namespace wayfare {

/// Causal; poses are delayed by stance_apart_s and half the window. `Statistic` is a
/// ZeroVelocityStatistic.
template <class Statistic>
class BasicFootTracker {
  static_assert(detail::check_stance_statistic<Statistic>());

 public:
  /// With SHOE or ARED, by FootParameters::statistic.
  explicit BasicFootTracker(
      const FootParameters& parameters = {}) requires std::same_as<Statistic, ShoeOrAred>
      : BasicFootTracker(parameters, ShoeOrAred(parameters)) {}
  /// With any statistic.
  BasicFootTracker(const FootParameters& parameters, const Statistic& statistic)
      : p_(parameters), readings_(parameters, statistic) {}

  /// Adds a reading and passes the poses that are due to `sink(const FootPose&)`. Needs both
  /// sensors; a reading that cannot be used leaves the state unchanged.
  template <class Sink>
  UpdateStatus add(const ImuSample& sample, Sink&& sink) {
    const UpdateStatus status = check(sample);
    if (status != UpdateStatus::used && status != UpdateStatus::saturated) return status;
    if (restarted_) finish(sink);
    restarted_ = false;
    readings_.add(sample);
    process(sink);
    return status;
  }
  /// The same, without the poses.
  UpdateStatus add(const ImuSample& sample) {
    return add(sample, [](const FootPose&) {});
  }
  /// Passes the remaining poses to `sink`, at the end of a recording.
  template <class Sink>
  void finish(Sink&& sink) {
    readings_.close();
    process(sink);
    readings_.clear();
  }

  /// Whether the attitude is initialised.
  [[nodiscard]] bool ready() const { return ready_; }
  /// The latest pose.
  [[nodiscard]] const FootPose& pose() const { return pose_; }
  /// State, covariance and biases.
  [[nodiscard]] const FootFilter& filter() const { return filter_; }
  /// To correct the state by other measurements, such as TwoFeet's.
  [[nodiscard]] FootFilter& filter() { return filter_; }
  /// Counts so far.
  [[nodiscard]] const FootReport& report() const { return report_; }

 private:
  using Vector = Eigen::Vector3d;
  static constexpr double kPatience_s = 1.0;

  UpdateStatus check(const ImuSample& s) {
    const double rate = s.angular_rate_radps.cwiseAbs().maxCoeff();
    const double force = s.specific_force_mps2.cwiseAbs().maxCoeff();
    const bool has_rate = s.angular_rate_radps.allFinite();
    const bool has_force = s.specific_force_mps2.allFinite();
    const auto verdict = [](bool has, double reading, double range) {
      return !has               ? UpdateStatus::missing
             : reading >= range ? UpdateStatus::saturated
                                : UpdateStatus::used;
    };
    UpdateStatus gyro = verdict(has_rate, rate, p_.rate_range);
    UpdateStatus accelerometer = verdict(has_force, force, p_.force_range);
    UpdateStatus both = !has_rate || !has_force      ? UpdateStatus::missing
                        : gyro != UpdateStatus::used ? gyro
                                                     : accelerometer;
    // Readings far outside the range are invalid.
    const bool invalid = rate > 4.0 * p_.rate_range || force > 4.0 * p_.force_range;
    if (both != UpdateStatus::missing && !invalid) {
      const auto when = clock_.check(s.time);
      if (when == SampleClock::Verdict::late) gyro = accelerometer = both = UpdateStatus::late;
      if (when == SampleClock::Verdict::first) restarted_ = true;
    } else if (invalid) {
      both = UpdateStatus::missing;
    }
    report_.gyro.note(gyro);
    report_.accelerometer.note(accelerometer);
    return both;
  }

  template <class Sink>
  void process(Sink&& sink) {
    FootReading entry;
    while (readings_.next(entry)) {
      step(entry);
      if (!ready_) continue;
      write_pose(entry);
      sink(static_cast<const FootPose&>(pose_));
    }
  }

  void step(const FootReading& e) {
    stance_ = 0.0;
    const double dt = has_last_ ? to_seconds(e.time - last_.time) : 0.0;
    if (!ready_) {
      start(e);
    } else if (!(dt > 0.0) || dt > p_.longest_gap_s) {
      bridge(dt > 0.0 ? dt : kPatience_s);
    } else {
      filter_.predict(e.angular_rate_radps, e.specific_force_mps2, p_.gravity_mps2, dt);
      filter_.add_noise(noise_(last_, e, filter_.q_world_foot(), dt));
      since_stance_s_ += dt;
      if (e.stillest) update_stance(e);
      if (const auto bias = rest_.add(e.angular_rate_radps, e.statistic, dt))
        filter_.observe<FootFilter::kRateBias>(bias->rate_radps,
                                               bias->sigma_radps * bias->sigma_radps);
    }
    last_ = static_cast<const ImuSample&>(e);
    has_last_ = true;
  }

  /// Starts at the first reading whose force is close to gravity.
  void start(const FootReading& e) {
    const double norm = e.specific_force_mps2.norm();
    if (!(std::abs(norm - p_.gravity_mps2) < 0.5 * p_.gravity_mps2)) return;
    level(e, e.statistic < p_.quiet_statistic);
    filter_.set_position(Vector::Zero(), 0.0);
    filter_.set_bias_variances(p_.rate_bias_sigma * p_.rate_bias_sigma,
                               p_.force_bias_sigma * p_.force_bias_sigma);
    q_start_ = filter_.q_world_foot();
    ready_ = true;
  }

  /// Resets velocity and tilt from a reading; keeps the heading, which is not observable.
  void level(const FootReading& e, bool quiet) {
    const SO3d& q = filter_.q_world_foot();
    const Vector up = q * e.specific_force_mps2;
    const SO3d upright = SO3d::between(up, Vector::UnitZ());
    const double tilt = quiet ? p_.start_tilt_sigma : 10.0 * p_.start_tilt_sigma;
    const double heading2 = filter_.covariance()(8, 8);
    filter_.set_attitude(upright * q, {tilt * tilt, tilt * tilt, heading2});
    const double speed = quiet ? p_.stance_speed : p_.stance_speed_limit;
    filter_.set_velocity(Vector::Zero(), speed * speed);
    since_stance_s_ = 0.0;
    rest_.interrupt();
  }

  void bridge(double gap_s) {
    constexpr double kSpeed_mps = 2.0;
    ++report_.gaps;
    filter_.set_velocity(Vector::Zero(), kSpeed_mps * kSpeed_mps);
    filter_.add_noise(FootNoise::pause(gap_s, kSpeed_mps));
    rest_.interrupt();
  }

  void update_stance(const FootReading& e) {
    const double variance = p_.stance_speed * p_.stance_speed * (1.0 + e.statistic);
    if (!(variance < p_.stance_speed_limit * p_.stance_speed_limit)) return;
    const double quiet = std::max(1.0, p_.quiet_statistic / std::max(e.statistic, 1e-6));
    stance_ = filter_.update_zero_velocity(variance, p_.moving_speed * p_.moving_speed,
                                           p_.quiet_power * std::log(quiet));
    if (stance_ > 0.5) {
      ++report_.stances;
      since_stance_s_ = 0.0;
      update_height();
      return;
    }
    ++report_.rejected;
    if (since_stance_s_ < p_.lost_after_s) return;
    ++report_.lost;
    level(e, e.statistic < p_.rest_statistic);
  }

  void update_height() {
    const double z = filter_.position().z();
    if (has_height_ && std::abs(z - height_m_) < p_.level_step_m)
      filter_.observe_along(Vector::UnitZ(), height_m_, p_.level_sigma_m * p_.level_sigma_m);
    height_m_ = filter_.position().z();
    has_height_ = true;
  }

  void write_pose(const FootReading& e) {
    const Eigen::Quaterniond rotation = (filter_.q_world_foot() * q_start_.inverse()).quaternion();
    pose_ = {e.time,
             filter_.position(),
             filter_.velocity(),
             filter_.q_world_foot(),
             filter_.covariance().topLeftCorner<3, 3>(),
             Angle::radians(2.0 * std::atan2(rotation.z(), rotation.w())).wrapped(),
             e.statistic,
             stance_};
  }

  FootParameters p_;
  FootReadings<Statistic> readings_;
  FootNoise noise_{p_};
  FootRest rest_{p_};
  FootFilter filter_;
  SampleClock clock_{kPatience_s};
  ImuSample last_;
  FootPose pose_;
  FootReport report_;
  SO3d q_start_;
  double since_stance_s_ = 0.0, height_m_ = 0.0, stance_ = 0.0;
  bool ready_ = false, has_last_ = false, has_height_ = false, restarted_ = false;
};
using FootTracker = BasicFootTracker<ShoeOrAred>;  ///< by SHOE or ARED

}  // namespace wayfare
