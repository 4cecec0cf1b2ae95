#pragma once

// Attitude and heading from gyro, accelerometer and (where there is one) magnetometer.

#include <concepts>

#include <Eigen/Core>

#include <wayfare/estimate/ahrs_parameters.hpp>
#include <wayfare/estimate/ahrs_report.hpp>
#include <wayfare/estimate/ahrs_updates.hpp>
#include <wayfare/estimate/attitude.hpp>

namespace wayfare {

/// Causal attitude of a body in `W` (frame::Ned or frame::Enu), true north where the declination is
/// given. Readings may come at any and irregular rates, each sensor at its own; a gyro reading
/// speaks for the time since the one before it. Starts at rest or in motion, needs gyro and
/// accelerometer, and no memory beyond itself. Without magnetometer the heading starts at zero and
/// drifts with the gyro. Not for vehicles: long turns and braking look like a tilt.
template <LevelFrame W = frame::Ned, std::floating_point T = double>
class Ahrs {
 public:
  using World = W;
  using Scalar = T;
  using Vector = Eigen::Matrix<T, 3, 1>;
  using Covariance = Eigen::Matrix<T, 3, 3>;

  explicit Ahrs(const AhrsParameters& parameters = {}) : updates_(parameters) {}

  /// One sensor's reading; those of one instant in this order.
  Intake add_rate(LogTime time, const Vector& radps) { return updates_.add_rate(time, radps); }
  Intake add_force(LogTime time, const Vector& mps2) { return updates_.add_force(time, mps2); }
  Intake add_field(LogTime time, const Vector& uT) { return updates_.add_field(time, uT); }

  MargIntake add(const MargSample& s) {
    return {add_rate(s.time, s.angular_rate_radps.cast<T>()),
            add_force(s.time, s.specific_force_mps2.cast<T>()),
            add_field(s.time, s.magnetic_field_uT.cast<T>())};
  }

  /// Whether there is an attitude, and whether its heading has a meaning beyond being its own.
  [[nodiscard]] bool ready() const { return updates_.ready(); }
  [[nodiscard]] bool heading_known() const { return updates_.heading_known(); }

  /// At the time of the last gyro reading.
  [[nodiscard]] SO3<T> q_world_body() const {
    return rotation_from_enu<World, T>() * updates_.filter().q_enu_body();
  }
  /// Of the attitude's error as a rotation vector in world axes, rad²; its last diagonal element is
  /// the heading's variance.
  [[nodiscard]] Covariance world_covariance() const {
    const Covariance c = rotation_from_enu<World, T>().matrix();
    return c * attitude_covariance() * c.transpose();
  }
  /// The same in body axes, as the library's perturbations are: q ⊞ τ = q·exp(τ).
  [[nodiscard]] Covariance body_covariance() const {
    const Covariance& r = updates_.filter().rotation();
    return r.transpose() * attitude_covariance() * r;
  }

  [[nodiscard]] Vector gyro_bias_radps() const { return updates_.filter().bias(); }
  [[nodiscard]] Vector gyro_bias_sigma_radps() const {
    const auto& p = updates_.filter().covariance();
    return Vector(p(3, 3), p(4, 4), p(5, 5)).cwiseSqrt();
  }
  [[nodiscard]] T magnetometer_delay_s() const { return updates_.filter().delay(); }
  [[nodiscard]] bool at_rest() const { return updates_.at_rest(); }

  /// Gives the heading from outside: the direction of the body's x axis, clockwise from north.
  void set_compass(Angle x_axis, Angle sigma) { updates_.set_compass(x_axis, sigma); }

  [[nodiscard]] const AhrsReport& report() const { return updates_.report(); }
  /// The last readings' squared innovations over their variances.
  [[nodiscard]] const AhrsInnovations<T>& innovations() const { return updates_.innovations(); }

 private:
  [[nodiscard]] Covariance attitude_covariance() const {
    const auto& p = updates_.filter().covariance();
    return (Covariance() << p(0, 0), p(0, 1), p(0, 2), p(1, 0), p(1, 1), p(1, 2), p(2, 0), p(2, 1),
            p(2, 2))
        .finished();
  }

  AhrsUpdates<T> updates_;
};

}  // namespace wayfare
