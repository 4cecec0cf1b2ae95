#pragma once

// Front end of the AHRS: checks of the readings, propagation by the gyro, restarts.

#include <algorithm>
#include <cmath>
#include <utility>

#include <Eigen/Core>

#include <wayfare/inertial/ahrs_parameters.hpp>
#include <wayfare/inertial/attitude.hpp>
#include <wayfare/inertial/detail/ahrs_filter.hpp>
#include <wayfare/inertial/detail/ahrs_heading.hpp>
#include <wayfare/inertial/detail/ahrs_level.hpp>
#include <wayfare/inertial/detail/external_heading.hpp>
#include <wayfare/inertial/detail/sample_clock.hpp>

namespace wayfare {

/// Growth of the attitude variance over one gyro reading.
template <class T>
class GyroNoise {
 public:
  using Padded = PaddedVector<T>;

  explicit GyroNoise(const AhrsParameters& p)
      : rate2_(T(p.rate_noise * p.rate_noise)),
        scale2_(T(p.rate_scale_noise * p.rate_scale_noise)),
        walk2_(T(p.bias_walk * p.bias_walk)),
        saturated2_(T(p.saturated_part * p.saturated_part)) {}

  /// Variance gained about any axis over dt, rad², at mean rate `rate` after `last`. `coarse`: dt
  /// is too long to assume a constant rate.
  T angle_variance(const Padded& rate, const Padded& last, T dt, bool coarse, bool saturated) {
    const T square = rate.squaredNorm();
    T variance = (rate2_ + scale2_ * square) * dt;
    if (coarse) variance += T(0.25) * (rate - last).squaredNorm() * dt * dt;
    // The error of a saturated gyro is constant: its standard deviation grows linearly with time.
    const T before = saturated_s_;
    saturated_s_ = saturated ? saturated_s_ + dt : T(0);
    if (saturated)
      variance += saturated2_ * square * (saturated_s_ * saturated_s_ - before * before);
    return variance;
  }
  [[nodiscard]] T bias_variance(T dt) const { return walk2_ * dt; }

 private:
  T rate2_, scale2_, walk2_, saturated2_;
  T saturated_s_ = T(0);
};

/// Implementation of Ahrs, in east-north-up.
template <class T>
class AhrsReadings {
 public:
  using Vector = Eigen::Matrix<T, 3, 1>;
  using Padded = PaddedVector<T>;

  explicit AhrsReadings(const AhrsParameters& p)
      : p_(p), gyro_noise_(p), level_(p), heading_(p), external_(p) {
    filter_.forget_bias(p_);
  }

  UpdateStatus add_rate(LogTime time, const Vector& radps) {
    const Padded rate(radps);
    const Check j = check(rate, gyro_, time);
    if (!j.usable) return report_.gyro.note(j.status);
    if (j.first || gyro_.clock.step_s() > p_.restart_gap_s) {
      restart();
    } else {
      propagate(time, rate, j.status == UpdateStatus::saturated);
    }
    last_rate_ = rate;
    return report_.gyro.note(j.status);
  }

  UpdateStatus add_force(LogTime time, const Vector& mps2) {
    const Padded force(mps2);
    const Check j = check(force, accelerometer_, time);
    if (!j.usable) return report_.accelerometer.note(j.status);
    const T after_s = after_gyro(time);
    if (!gyro_is_near(after_s) || (!ready_ && !start(force))) {
      accelerometer_.clock.forget();
      return report_.accelerometer.note(UpdateStatus::waiting);
    }
    const T dt = T(accelerometer_.clock.step_s());
    if (j.first || dt > T(kLongestHold_s)) {
      level_.reset_velocity(filter_);
    } else {
      const Padded world = in_world(force, after_s - T(0.5) * dt);
      const T variance = force_variance(force, dt, j.status == UpdateStatus::saturated);
      report_.level_resets += level_.add_force(filter_, force, world, dt, variance) ? 1 : 0;
    }
    return report_.accelerometer.note(j.status);
  }

  UpdateStatus add_field(LogTime time, const Vector& uT) {
    const Padded field(uT);
    // A magnetometer without power or calibration reads zero: no direction.
    if (field.squaredNorm() < T(1e-12)) return report_.magnetometer.note(UpdateStatus::missing);
    const Check j = check(field, magnetometer_, time);
    if (!p_.use_magnetometer || !j.usable || j.status == UpdateStatus::saturated)
      return report_.magnetometer.note(p_.use_magnetometer ? j.status : UpdateStatus::missing);
    const T after_s = after_gyro(time);
    if (!ready_ || !gyro_is_near(after_s)) return report_.magnetometer.note(UpdateStatus::waiting);
    const T dt = std::min(T(magnetometer_.clock.step_s()), T(kLongestHold_s));
    fields_.sum += in_world(field, after_s - filter_.delay());
    fields_.span_s += dt;
    fields_.count += T(1);
    if (heading_.known() && fields_.span_s < AhrsFilter<T>::kFieldUpdate_s)
      return report_.magnetometer.note(field_status_);
    if (heading_.known())
      filter_.propagate();
    else
      settle();
    const Fields mean = std::exchange(fields_, {});
    const auto outcome = heading_.update(filter_, mean.sum / mean.count,
                                         filter_.without_bias(last_rate_), mean.span_s);
    field_status_ = outcome.status;
    report_.heading_resets += outcome.reset ? 1 : 0;
    if (outcome.reset) {
      external_.settle();
      level_.skip();
    }
    return report_.magnetometer.note(outcome.status);
  }

  UpdateStatus add_heading(const HeadingFix& fix) {
    if (!ready_ || !external_.on()) return report_.external.note(UpdateStatus::waiting);
    const auto outcome = external_.update(filter_, fix, heading_.known());
    if (outcome.reset) {
      report_.heading_resets += heading_.known() ? 1 : 0;
      settle();
      heading_.reset(filter_, outcome.off, outcome.sigma);
      fields_ = {};
    }
    return report_.external.note(outcome.status);
  }

  UpdateStatus set_compass(Angle x_axis, Angle sigma) {
    // Squares of both are computed, also as floats.
    if (!(std::abs(x_axis.radians()) < 1e9) || !(std::abs(sigma.radians()) < 1e9))
      return UpdateStatus::missing;
    if (!ready_) return UpdateStatus::waiting;
    settle();
    heading_.set(filter_, x_axis, sigma);
    fields_ = {};
    external_.settle();
    return UpdateStatus::used;
  }

  [[nodiscard]] bool ready() const { return ready_; }
  [[nodiscard]] const AhrsFilter<T>& filter() const { return filter_; }
  [[nodiscard]] const AhrsLevel<T>& level() const { return level_; }
  [[nodiscard]] const AhrsHeading<T>& heading() const { return heading_; }
  [[nodiscard]] const ExternalHeading<T>& external() const { return external_; }
  [[nodiscard]] const AhrsReport& report() const { return report_; }

 private:
  static constexpr double kLongestHold_s = 0.25;  // for which the last reading remains valid

  /// Of readings since the heading was updated, in world axes.
  struct Fields {
    Padded sum;
    T span_s = T(0), count = T(0);
  };

  struct Sensor {
    T range;
    SampleClock clock;
  };
  struct Check {
    UpdateStatus status = UpdateStatus::used;
    bool usable = false;
    bool first = false;  ///< no previous reading
  };

  /// A saturated reading is still usable; one of several times the range is not.
  static Check check(const Padded& reading, Sensor& sensor, LogTime time) {
    const T limit = sensor.range;
    auto status = UpdateStatus::used;
    if (!(reading.squaredNorm() < limit * limit)) {  // also where it is not finite
      if (!reading.allFinite()) return {UpdateStatus::missing};
      const T largest = reading.cwiseAbs().maxCoeff();
      if (largest > T(4) * limit) return {UpdateStatus::saturated};
      if (largest >= limit) status = UpdateStatus::saturated;
    }
    const auto verdict = sensor.clock.check(time);
    if (verdict == SampleClock::Verdict::late) return {UpdateStatus::late};
    return {status, true, verdict == SampleClock::Verdict::first};
  }

  [[nodiscard]] T after_gyro(LogTime time) const {
    return T(to_seconds(time - gyro_.clock.last()));
  }
  [[nodiscard]] bool gyro_is_near(T after_gyro_s) const {
    return gyro_.clock.started() && std::abs(after_gyro_s) <= T(kLongestHold_s);
  }
  /// `v`, measured `after_s` after the attitude's time, in world axes.
  [[nodiscard]] Padded in_world(const Padded& v, T after_s) const {
    Padded angle = filter_.without_bias(last_rate_) * after_s;
    const T angle2 = angle.squaredNorm();
    if (angle2 > T(0.25)) angle *= T(0.5) / std::sqrt(angle2);
    const Padded first = angle.cross(v);
    return filter_.in_world(v + first + T(0.5) * angle.cross(first));
  }

  /// Covariance and levelling up to now.
  void settle() {
    filter_.propagate();
    report_.level_resets += level_.settle(filter_) ? 1 : 0;
  }

  void restart() {
    report_.restarts += ready_ ? 1 : 0;
    ready_ = false;
    heading_.forget();
    accelerometer_.clock.forget();
    magnetometer_.clock.forget();
    level_.forget_rest();
    external_.forget();
    fields_ = {};
  }

  bool start(const Padded& force) {
    ready_ = level_.start(filter_, force.unpadded(), last_rate_.unpadded());
    // An unknown heading defines the frame: it has no error and no correlations.
    if (ready_) filter_.turn_heading(T(0), T(0));
    return ready_;
  }

  void propagate(LogTime time, const Padded& rate, bool saturated) {
    const T dt = T(gyro_.clock.step_s());
    level_.add_rate(rate, dt);
    if (!ready_) return;
    const bool coarse = gyro_.clock.step_s() > p_.coarse_gap_s;
    const Padded mean = coarse ? Padded(T(0.5) * (rate + last_rate_)) : rate;
    const T variance = gyro_noise_.angle_variance(mean, last_rate_, dt, coarse, saturated);
    const Padded corrected = filter_.without_bias(mean);
    if (!external_.on())
      return filter_.rotate(corrected, dt, variance, gyro_noise_.bias_variance(dt));
    const auto turn = external_.begin_turn(filter_, dt, variance);
    filter_.turn(corrected, dt, variance, gyro_noise_.bias_variance(dt));
    external_.end_turn(time, turn, filter_);
  }

  /// Of the velocity gained by a force over dt.
  [[nodiscard]] T force_variance(const Padded& force, T dt, bool saturated) const {
    T variance = force_noise2_ * dt;
    if (saturated)
      variance += T(p_.saturated_part * p_.saturated_part) * force.squaredNorm() * dt * dt;
    return variance;
  }

  AhrsParameters p_;
  AhrsFilter<T> filter_;
  GyroNoise<T> gyro_noise_;
  AhrsLevel<T> level_;
  AhrsHeading<T> heading_;
  ExternalHeading<T> external_;
  Sensor gyro_{T(p_.rate_range), SampleClock(p_.restart_gap_s)},
      accelerometer_{T(p_.force_range), SampleClock(p_.restart_gap_s)},
      magnetometer_{T(p_.field_range), SampleClock(p_.restart_gap_s)};
  T force_noise2_ = T(p_.force_noise * p_.force_noise);
  Padded last_rate_;
  Fields fields_;
  UpdateStatus field_status_ = UpdateStatus::waiting;
  bool ready_ = false;
  AhrsReport report_;
};

}  // namespace wayfare
