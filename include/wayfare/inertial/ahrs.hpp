#pragma once

// Attitude and heading from gyro, accelerometer and, optionally, magnetometer: Ahrs, and the
// baseline filters of Madgwick and Mahony with the same interface.

#include <algorithm>
#include <cmath>
#include <concepts>

#include <Eigen/Core>

#include <wayfare/core/se3.hpp>
#include <wayfare/inertial/ahrs_parameters.hpp>
#include <wayfare/inertial/attitude.hpp>
#include <wayfare/inertial/detail/ahrs_readings.hpp>
#include <wayfare/inertial/detail/sample_clock.hpp>

namespace wayfare {

/// Mahony et al. 2008 (32): the gyro's rate is corrected in proportion to the error and its
/// integral. Gains in 1/s and 1/s².
struct MahonyRule {
  /// Correction per error, 1/s; larger: trusts force and field more.
  double proportional_gain = 0.74;
  double integral_gain = 0.0012;  ///< of the gyro bias, 1/s²; larger: faster, noisier
  bool use_magnetometer = true;   ///< else the heading is by the gyro alone

  template <class Vector, class T>
  /// Correction of the rate, rad/s, for an error in rad; `integral` sums its second part.
  Vector operator()(const Vector& error, Vector& integral, T dt) const {
    integral += T(integral_gain) * dt * error;
    return T(proportional_gain) * error + integral;
  }
};

/// Madgwick et al. 2011 (33), (42): gradient descent of the quaternion with rate `gain` (β, rad/s):
/// a rotation in the direction of Mahony's error, but at constant speed.
struct MadgwickRule {
  double gain = 0.12;            ///< β, rad/s: speed of the correction, above the gyro's drift
  bool use_magnetometer = true;  ///< else the heading is by the gyro alone

  template <class Vector, class T>
  /// Correction of the rate, rad/s.
  Vector operator()(const Vector& error, Vector& /*integral*/, T /*dt*/) const {
    const T norm = error.norm();
    return norm > T(0) ? Vector(T(2.0 * gain) / norm * error) : Vector(Vector::Zero());
  }
};

/// `Rule` maps the error to a correction of the rate. The error is the rotation, in body axes, that
/// would align accelerometer and magnetometer with up and north.
template <class Rule, LevelFrame W = frame::Ned, std::floating_point T = double>
class BasicAhrs {
 public:
  using World = W;                        ///< frame of the attitude
  using Scalar = T;                       ///< of the filter
  using Vector = Eigen::Matrix<T, 3, 1>;  ///< in body axes

  /// Without readings.
  explicit BasicAhrs(const Rule& rule = {}) : rule_(rule) {}

  /// One sensor's reading. Force and field are held until the next one and act at each rate; a rate
  /// acts for a second at most. Rates above 1000 rad/s are `saturated` and not used.
  UpdateStatus add_rate(LogTime time, const Vector& radps) {
    if (!radps.allFinite()) return UpdateStatus::missing;
    if (radps.cwiseAbs().maxCoeff() > T(1e3)) return UpdateStatus::saturated;
    const auto verdict = rate_clock_.check(time);
    if (verdict == SampleClock::Verdict::late) return UpdateStatus::late;
    if (!ready_) return UpdateStatus::waiting;
    const T dt = T(std::min(rate_clock_.step_s(), 1.0));
    q_ = q_ * SO3<T>::exp((radps + rule_(error(), integral_, dt)) * dt);
    return UpdateStatus::used;
  }
  /// Specific force, m/s².
  UpdateStatus add_force(LogTime time, const Vector& mps2) { return hold(time, mps2, force_); }
  /// Magnetic field, µT; `missing` where the rule does not use it.
  UpdateStatus add_field(LogTime time, const Vector& uT) {
    return rule_.use_magnetometer ? hold(time, uT, field_) : UpdateStatus::missing;
  }
  /// Force, field, then rate of one sample.
  MargUpdateStatus add(const MargSample& s) {
    const UpdateStatus force = add_force(s.time, s.specific_force_mps2.cast<T>());
    const UpdateStatus field = add_field(s.time, s.magnetic_field_uT.cast<T>());
    return {add_rate(s.time, s.angular_rate_radps.cast<T>()), force, field};
  }

  /// Whether there is an attitude.
  [[nodiscard]] bool ready() const { return ready_; }
  /// At the time of the last rate.
  [[nodiscard]] SO3<T> q_world_body() const { return rotation_from_enu<World, T>() * q_; }

 private:
  struct Held {
    Vector direction = Vector::Zero();  // none yet
    SampleClock clock{1.0};
  };

  UpdateStatus hold(LogTime time, const Vector& reading, Held& held) {
    if (!reading.allFinite()) return UpdateStatus::missing;
    if (held.clock.check(time) == SampleClock::Verdict::late) return UpdateStatus::late;
    const T norm = reading.norm();
    if (!(norm > T(0)) || !std::isfinite(norm)) return UpdateStatus::missing;
    held.direction = reading / norm;
    if (!ready_) start();
    return UpdateStatus::used;
  }

  /// Up from the accelerometer, then north from the magnetometer, if used.
  void start() {
    if (force_.direction.isZero() || (rule_.use_magnetometer && field_.direction.isZero())) return;
    q_ = SO3<T>::between(force_.direction, Vector::UnitZ());
    const Vector m = q_ * field_.direction;
    if (rule_.use_magnetometer) q_ = SO3<T>::exp({T(0), T(0), std::atan2(m.x(), m.y())}) * q_;
    ready_ = true;
  }

  [[nodiscard]] Vector error() const {
    const auto r = q_.matrix();
    Vector e = force_.direction.cross(r.row(2).transpose());
    if (rule_.use_magnetometer) {
      // The reference field has the measured dip, so that it corrects the heading only.
      const Vector m = r * field_.direction;
      const Vector north(T(0), std::hypot(m.x(), m.y()), m.z());
      e += field_.direction.cross(r.transpose() * north);
    }
    return e;
  }

  Rule rule_;
  SO3<T> q_;
  bool ready_ = false;
  Vector integral_ = Vector::Zero();
  Held force_, field_;
  SampleClock rate_clock_{1.0};
};

template <LevelFrame W = frame::Ned, std::floating_point T = double>
using MadgwickAhrs = BasicAhrs<MadgwickRule, W, T>;  ///< Madgwick's filter
template <LevelFrame W = frame::Ned, std::floating_point T = double>
using MahonyAhrs = BasicAhrs<MahonyRule, W, T>;  ///< Mahony's filter

/// Causal attitude of a body in `W` (frame::Ned or frame::Enu), relative to true north if the
/// declination is given. Each sensor may have its own, irregular rate. A gyro or accelerometer
/// reading is the mean since the previous one; a magnetometer reading is instantaneous. Each gyro
/// reading turns the attitude; forces and fields correct it by their means over 40 and 30 ms.
/// Starts at rest or in motion; needs gyro and accelerometer; allocates no memory. Without
/// magnetometer the heading starts at zero and drifts with the gyro. Not for vehicles: sustained
/// turns and braking look like a tilt.
template <LevelFrame W = frame::Ned, std::floating_point T = double>
class Ahrs {
 public:
  using World = W;                            ///< frame of the attitude
  using Scalar = T;                           ///< of the filter
  using Vector = Eigen::Matrix<T, 3, 1>;      ///< of three components
  using Covariance = Eigen::Matrix<T, 3, 3>;  ///< of the attitude error

  /// Without readings.
  explicit Ahrs(const AhrsParameters& parameters = {}) : readings_(parameters) {}

  /// One sensor's reading; simultaneous readings in this order.
  UpdateStatus add_rate(LogTime time, const Vector& radps) {
    return readings_.add_rate(time, radps);
  }
  /// Specific force, m/s².
  UpdateStatus add_force(LogTime time, const Vector& mps2) {
    return readings_.add_force(time, mps2);
  }
  /// Magnetic field, µT.
  UpdateStatus add_field(LogTime time, const Vector& uT) { return readings_.add_field(time, uT); }

  /// Rate, force, then field of one sample.
  MargUpdateStatus add(const MargSample& s) {
    return {add_rate(s.time, s.angular_rate_radps.cast<T>()),
            add_force(s.time, s.specific_force_mps2.cast<T>()),
            add_field(s.time, s.magnetic_field_uT.cast<T>())};
  }

  /// Whether there is an attitude, and whether its heading refers to north.
  [[nodiscard]] bool ready() const { return readings_.ready(); }
  /// Relative to north, by the magnetometer or external headings.
  [[nodiscard]] bool heading_known() const { return readings_.heading().known(); }

  /// At the time of the last gyro reading.
  [[nodiscard]] SO3<T> q_world_body() const {
    return rotation_from_enu<World, T>() * filter().q_enu_body();
  }
  /// Covariance of the attitude error as a rotation vector in world axes, rad²; the last diagonal
  /// element is the heading variance.
  [[nodiscard]] Covariance world_covariance() const {
    const Covariance c = rotation_from_enu<World, T>().matrix();
    return c * attitude_covariance() * c.transpose();
  }
  /// The same in body axes, the library's right perturbation q ⊞ τ = q·exp(τ).
  [[nodiscard]] Covariance body_covariance() const {
    const Covariance& r = filter().rotation();
    return r.transpose() * attitude_covariance() * r;
  }
  /// Of the heading, rad²: as in world_covariance(), without the other elements.
  [[nodiscard]] T heading_variance() const { return filter().heading_variance(); }

  /// In body axes.
  [[nodiscard]] Vector gyro_bias_radps() const { return filter().bias(); }
  /// Its standard deviation.
  [[nodiscard]] Vector gyro_bias_sigma_radps() const {
    const auto p = covariance();
    return Vector(p(3, 3), p(4, 4), p(5, 5)).cwiseSqrt();
  }
  /// Estimated delay of the magnetometer's time stamps.
  [[nodiscard]] T magnetometer_delay_s() const { return filter().delay(); }
  /// By the rest detector.
  [[nodiscard]] bool at_rest() const { return readings_.level().at_rest(); }

  /// Sets the heading: direction of the body's x axis, clockwise from north. `waiting`, without
  /// effect, before there is an attitude; `missing` if not finite or beyond 1e9 rad.
  UpdateStatus set_compass(Angle x_axis, Angle sigma) {
    return readings_.set_compass(x_axis, sigma);
  }

  /// External heading of AhrsParameters::heading_axis, up to AhrsParameters::heading_history_s old:
  /// corrects attitude and gyro bias. The first one initialises an unknown heading. `waiting`: no
  /// attitude at that time yet; `late`: older than the history, or not after the previous fix;
  /// `missing`: not finite, or variance not positive; `disturbed`: rejected by the gate.
  UpdateStatus add_heading(const HeadingFix& fix) { return readings_.add_heading(fix); }
  /// Rotation of that axis integrated from the gyro alone, counter-clockwise seen from above.
  [[nodiscard]] const HeadingTrack& heading_track() const { return readings_.external().track(); }

  /// Counts of readings and resets.
  [[nodiscard]] const AhrsReport& report() const { return readings_.report(); }
  /// Normalised innovation squared of the last corrections, one degree of freedom each.
  [[nodiscard]] AhrsNis<T> nis() const {
    const auto& level = readings_.level().nis();
    return {level[0], level[1], readings_.heading().nis(), readings_.external().nis()};
  }

 private:
  [[nodiscard]] const AhrsFilter<T>& filter() const { return readings_.filter(); }
  /// With the rotations since the last measurement.
  [[nodiscard]] auto covariance() const {
    AhrsFilter<T> now = filter();
    now.propagate();
    return now.covariance();
  }
  [[nodiscard]] Covariance attitude_covariance() const {
    return covariance().dense().template topLeftCorner<3, 3>();
  }

  AhrsReadings<T> readings_;
};

}  // namespace wayfare
