#pragma once

// What the AHRS does with each reading: checks it, moves the filter, and notices when it is lost.

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <Eigen/Core>

#include <wayfare/core/angle.hpp>
#include <wayfare/estimate/ahrs_alignment.hpp>
#include <wayfare/estimate/ahrs_filter.hpp>
#include <wayfare/estimate/ahrs_parameters.hpp>
#include <wayfare/estimate/ahrs_report.hpp>
#include <wayfare/estimate/magnetic_gate.hpp>
#include <wayfare/estimate/rest_detector.hpp>
#include <wayfare/estimate/sample_clock.hpp>
#include <wayfare/estimate/velocity_model.hpp>

namespace wayfare {

/// Squares of innovations over their variances; NaN before the first.
template <class T>
struct AhrsInnovations {
  T velocity_east = std::numeric_limits<T>::quiet_NaN();
  T velocity_north = std::numeric_limits<T>::quiet_NaN();
  T heading = std::numeric_limits<T>::quiet_NaN();
};

/// The inside of Ahrs, in east-north-up.
template <class T>
class AhrsUpdates {
 public:
  using Vector = Eigen::Matrix<T, 3, 1>;

  explicit AhrsUpdates(const AhrsParameters& parameters)
      : p_(parameters),
        velocity_model_(parameters),
        rest_(T(parameters.rest_rate), T(parameters.rest_force)),
        gate_(parameters) {
    align::forget_bias(filter_, p_);
  }

  Intake add_rate(LogTime time, const Vector& rate) {
    SensorReport& count = report_.gyro;
    if (!rate.allFinite()) return count.note(Intake::missing);
    const T largest = rate.cwiseAbs().maxCoeff();
    if (largest > T(kAbsurd * p_.rate_range)) return count.note(Intake::saturated);
    const auto verdict = rate_clock_.check(time);
    if (verdict == SampleClock::Verdict::late) return count.note(Intake::late);
    const T dt = T(rate_clock_.step_s());
    const bool saturated = largest >= T(p_.rate_range);
    if (verdict == SampleClock::Verdict::first || dt > T(p_.restart_gap_s)) {
      restart();
    } else {
      turn(rate, dt, saturated);
    }
    last_rate_ = rate;
    return count.note(saturated ? Intake::saturated : Intake::used);
  }

  Intake add_force(LogTime time, const Vector& force) {
    SensorReport& count = report_.accelerometer;
    if (!force.allFinite()) return count.note(Intake::missing);
    const T largest = force.cwiseAbs().maxCoeff();
    if (largest > T(kAbsurd * p_.force_range)) return count.note(Intake::saturated);
    const auto verdict = force_clock_.check(time);
    if (verdict == SampleClock::Verdict::late) return count.note(Intake::late);
    if (!gyro_is_near(time) || (!ready_ && !start(force))) {
      force_clock_.forget();
      return count.note(Intake::waiting);
    }
    const bool saturated = largest >= T(p_.force_range);
    const T dt = T(force_clock_.step_s());
    if (verdict == SampleClock::Verdict::first || dt > T(kLongestHold_s)) {
      align::forget_velocity(filter_, velocity_model_.variance());
    } else {
      move(time, force, dt, saturated);
    }
    return count.note(saturated ? Intake::saturated : Intake::used);
  }

  Intake add_field(LogTime time, const Vector& field) {
    SensorReport& count = report_.magnetometer;
    if (!p_.use_magnetometer || !field.allFinite()) return count.note(Intake::missing);
    if (field.cwiseAbs().maxCoeff() >= T(p_.field_range)) return count.note(Intake::saturated);
    const auto verdict = field_clock_.check(time);
    if (verdict == SampleClock::Verdict::late) return count.note(Intake::late);
    if (!ready_ || !gyro_is_near(time)) return count.note(Intake::waiting);
    const T dt = std::min(T(field_clock_.step_s()), T(kLongestHold_s));
    return count.note(turn_to(time, field, dt));
  }

  void set_compass(Angle x_axis, Angle sigma) {
    const Vector x = filter_.rotation().col(0);
    align::turn_heading(filter_, T(std::atan2(x.x(), x.y()) - x_axis.radians()),
                        T(sigma.radians()));
    heading_known_ = true;
  }

  [[nodiscard]] bool ready() const { return ready_; }
  [[nodiscard]] bool heading_known() const { return heading_known_; }
  [[nodiscard]] bool at_rest() const {
    return rest_.still_s() > T(p_.rest_time_s) &&
           rest_.mean_rate().squaredNorm() < T(p_.rest_bias_limit * p_.rest_bias_limit);
  }
  [[nodiscard]] const AhrsFilter<T>& filter() const { return filter_; }
  [[nodiscard]] const AhrsReport& report() const { return report_; }
  [[nodiscard]] const AhrsInnovations<T>& innovations() const { return innovations_; }
  [[nodiscard]] const MagneticGate<T>& magnetic_gate() const { return gate_; }

 private:
  template <int... Index>
  using Row = SparseRow<T, Index...>;

  static constexpr double kAbsurd = 4.0;          // times the range: not a reading at all
  static constexpr double kLongestHold_s = 0.25;  // that the last reading speaks for what follows
  static constexpr double kGravity = 9.80665;

  [[nodiscard]] bool gyro_is_near(LogTime time) const {
    return rate_clock_.started() &&
           std::abs(to_seconds(time - rate_clock_.last())) <= kLongestHold_s;
  }

  /// `v`, read `after_s` after the attitude's time, in world axes.
  [[nodiscard]] Vector in_world(const Vector& v, T after_s) const {
    Vector turn = (last_rate_ - filter_.bias()) * after_s;
    const T angle2 = turn.squaredNorm();
    if (angle2 > T(0.25)) turn *= T(0.5) / std::sqrt(angle2);
    const Vector first = turn.cross(v);
    return filter_.rotation() * (v + first + T(0.5) * turn.cross(first));
  }
  [[nodiscard]] T after_gyro(LogTime time) const {
    return T(to_seconds(time - rate_clock_.last()));
  }

  void restart() {
    if (ready_) ++report_.restarts;
    ready_ = heading_known_ = false;
    force_clock_.forget();
    field_clock_.forget();
    rest_.reset();
  }

  void turn(const Vector& rate, T dt, bool saturated) {
    rest_.add_rate(rate, dt);
    if (!ready_) return;
    const bool coarse = dt > T(p_.coarse_gap_s);
    const Vector w = (coarse ? Vector(T(0.5) * (rate + last_rate_)) : rate) - filter_.bias();
    const T w2 = w.squaredNorm();
    T variance = (rate_noise2_ + rate_scale2_ * w2) * dt;
    if (coarse) variance += T(1.0 / 16.0) * (rate - last_rate_).squaredNorm() * dt * dt;
    if (saturated) {
      // One error for the whole event, so that its standard deviation grows with time.
      const T before = saturated_s_;
      saturated_s_ += dt;
      variance += saturated2_ * w2 * (saturated_s_ * saturated_s_ - before * before);
    } else {
      saturated_s_ = T(0);
    }
    filter_.turn(w, dt, variance, bias_walk2_ * dt);
  }

  /// The first attitude, levelled by one reading of the accelerometer that could be gravity's.
  bool start(const Vector& force) {
    const T norm = force.norm();
    if (!(norm > T(0.5 * kGravity) && norm < T(1.5 * kGravity))) return false;
    const T off = norm / T(kGravity) - T(1);
    const T moving = last_rate_.norm() > T(0.3) ? T(0.17) : T(0);
    filter_.set_attitude(SO3<T>());
    align::level(filter_, force, std::sqrt(T(0.0012) + off * off + moving * moving));
    align::turn_heading(filter_, T(0), p_.use_magnetometer ? T(std::numbers::pi) : T(0));
    align::forget_velocity(filter_, velocity_model_.variance());
    level_mean_.setZero();
    lost_s_ = lost_heading_s_ = T(0);
    return ready_ = true;
  }

  void move(LogTime time, const Vector& force, T dt, bool saturated) {
    const Vector f = in_world(force, after_gyro(time) - T(0.5) * dt);
    rest_.add_force(force, dt);
    T variance = force_noise2_ * dt;
    if (saturated) variance += saturated2_ * force.squaredNorm() * dt * dt;
    filter_.accelerate(f, dt, variance);
    hold_velocity(f, dt);
    rest_s_ += dt;
    if (rest_s_ > T(0.05)) {
      if (at_rest()) use_rest(rest_s_);
      rest_s_ = T(0);
    }
    filter_.apply();
    find_level_again(f, force, dt);
  }

  /// The velocity's model as a measurement: v + reach·a is white noise (velocity_model.hpp).
  void hold_velocity(const Vector& f, T dt) {
    velocity_model_.set_step(dt);
    const T k = velocity_model_.reach(), r = velocity_model_.innovation_variance();
    const auto& v = filter_.velocity();
    innovations_.velocity_east =
        filter_.observe(Row<1, 2, 6>{{k * f.z(), -k * f.y(), T(1)}}, -(v.x() + k * f.x()), r);
    innovations_.velocity_north =
        filter_.observe(Row<0, 2, 7>{{-k * f.z(), k * f.x(), T(1)}}, -(v.y() + k * f.y()), r);
  }

  /// At rest the gyro reads its bias and the velocity is zero.
  void use_rest(T elapsed) {
    const T noise2 = T(p_.rest_rate_density * p_.rest_rate_density);
    const Vector off = rest_.mean_rate() - filter_.bias();
    for (int i = 0; i < 3; ++i) {
      // A slow steady turn is not a bias.
      const T expected = filter_.covariance()(3 + i, 3 + i) + T(2) * noise2;
      if (off[i] * off[i] > T(16) * expected) return;
    }
    const T r = noise2 / elapsed;
    filter_.observe(Row<3>{{T(1)}}, off.x(), r);
    filter_.observe(Row<4>{{T(1)}}, off.y(), r);
    filter_.observe(Row<5>{{T(1)}}, off.z(), r);
    const T rv = T(p_.rest_velocity_density * p_.rest_velocity_density) / elapsed;
    filter_.observe(Row<6>{{T(1)}}, -filter_.velocity().x(), rv);
    filter_.observe(Row<7>{{T(1)}}, -filter_.velocity().y(), rv);
  }

  void find_level_again(const Vector& f, const Vector& force, T dt) {
    level_mean_ += (f.template head<2>() - level_mean_) * (dt / (T(1) + dt));
    const T limit = T(rest_.still_s() > T(0.5) ? p_.lost_level_at_rest : p_.lost_level);
    lost_s_ = level_mean_.squaredNorm() > limit * limit ? lost_s_ + dt : T(0);
    if (lost_s_ < T(0.5) || std::abs(force.norm() - T(kGravity)) > T(0.3 * kGravity)) return;
    align::level(filter_, force, T(0.3));
    align::forget_velocity(filter_, velocity_model_.variance());
    level_mean_.setZero();
    lost_s_ = T(0);
    ++report_.levelled_anew;
  }

  Intake turn_to(LogTime time, const Vector& field, T dt) {
    const Vector w = last_rate_ - filter_.bias();
    const Vector m = in_world(field, after_gyro(time) - filter_.delay());
    const bool turning = w.squaredNorm() > T(0.35 * 0.35);
    const auto verdict = gate_.take(m, dt, turning);
    const T level2 = m.template head<2>().squaredNorm();
    if (level2 < T(0.0025) * m.squaredNorm()) return Intake::disturbed;  // too near a magnetic pole
    const T off = wrap_to_pi(T(std::atan2(m.x(), m.y()) - p_.declination.radians()));
    if (!heading_known_) {
      const auto& c = filter_.covariance();
      const T from_level = (c(0, 0) + c(1, 1)) * T(0.5) * m.z() * m.z() / level2;
      align::turn_heading(filter_, off, std::sqrt(T(0.03) + from_level));
      heading_known_ = true;
      return Intake::used;
    }
    if (verdict == MagneticGate<T>::Field::disturbed) return Intake::disturbed;
    if (verdict == MagneticGate<T>::Field::settling || dt <= T(0)) return Intake::waiting;
    // A later delay turns the field back by the rate: dm = −(R·w)×m.
    const Vector change = -(filter_.rotation() * w).cross(m);
    const T by_delay = (m.y() * change.x() - m.x() * change.y()) / level2;
    innovations_.heading = filter_.observe(Row<2, 8>{{T(1), -by_delay}}, off, heading_noise2_ / dt);
    filter_.apply();
    filter_.set_delay(std::clamp(filter_.delay(), T(-0.1), T(0.1)));
    find_heading_again(off, dt);
    return Intake::used;
  }

  void find_heading_again(T off, T dt) {
    lost_heading_s_ = std::abs(off) > T(p_.lost_heading.radians()) ? lost_heading_s_ + dt : T(0);
    if (lost_heading_s_ < T(p_.lost_heading_s)) return;
    align::turn_heading(filter_, off, T(0.2));
    lost_heading_s_ = T(0);
    ++report_.headings_taken;
  }

  AhrsParameters p_;
  T rate_noise2_ = T(p_.rate_noise * p_.rate_noise);
  T rate_scale2_ = T(p_.rate_scale_noise * p_.rate_scale_noise);
  T bias_walk2_ = T(p_.bias_walk * p_.bias_walk);
  T force_noise2_ = T(p_.force_noise * p_.force_noise);
  T heading_noise2_ = T(p_.heading_density * p_.heading_density);
  T saturated2_ = T(p_.saturated_rate_sigma * p_.saturated_rate_sigma);

  AhrsFilter<T> filter_;
  VelocityModel<T> velocity_model_;
  RestDetector<T> rest_;
  MagneticGate<T> gate_;
  SampleClock rate_clock_{p_.restart_gap_s}, force_clock_{p_.restart_gap_s},
      field_clock_{p_.restart_gap_s};
  Vector last_rate_ = Vector::Zero();
  Eigen::Matrix<T, 2, 1> level_mean_ = Eigen::Matrix<T, 2, 1>::Zero();
  T saturated_s_ = T(0), rest_s_ = T(0), lost_s_ = T(0), lost_heading_s_ = T(0);
  bool ready_ = false, heading_known_ = false;
  AhrsReport report_;
  AhrsInnovations<T> innovations_;
};

}  // namespace wayfare
