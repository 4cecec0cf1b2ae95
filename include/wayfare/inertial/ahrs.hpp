#pragma once

// Attitude and heading from gyro, accelerometer and, optionally, magnetometer.

#include <concepts>

#include <Eigen/Core>

#include <wayfare/inertial/ahrs_parameters.hpp>
#include <wayfare/inertial/attitude.hpp>
#include <wayfare/inertial/detail/ahrs_readings.hpp>

namespace wayfare {

/// Causal attitude of a body in `W` (frame::Ned or frame::Enu), relative to true north if the
/// declination is given. Each sensor may have its own, irregular rate. A gyro or accelerometer
/// reading is the mean since the previous one; a magnetometer reading is instantaneous. Starts at
/// rest or in motion; needs gyro and accelerometer; allocates no memory. Without magnetometer the
/// heading starts at zero and drifts with the gyro. Not for vehicles: sustained turns and braking
/// look like a tilt.
template <LevelFrame W = frame::Ned, std::floating_point T = double>
class Ahrs {
 public:
  using World = W;
  using Scalar = T;
  using Vector = Eigen::Matrix<T, 3, 1>;
  using Covariance = Eigen::Matrix<T, 3, 3>;

  explicit Ahrs(const AhrsParameters& parameters = {}) : readings_(parameters) {}

  /// One sensor's reading; simultaneous readings in this order.
  UpdateStatus add_rate(LogTime time, const Vector& radps) {
    return readings_.add_rate(time, radps);
  }
  UpdateStatus add_force(LogTime time, const Vector& mps2) {
    return readings_.add_force(time, mps2);
  }
  UpdateStatus add_field(LogTime time, const Vector& uT) { return readings_.add_field(time, uT); }

  MargUpdateStatus add(const MargSample& s) {
    return {add_rate(s.time, s.angular_rate_radps.cast<T>()),
            add_force(s.time, s.specific_force_mps2.cast<T>()),
            add_field(s.time, s.magnetic_field_uT.cast<T>())};
  }

  /// Whether there is an attitude, and whether its heading refers to north.
  [[nodiscard]] bool ready() const { return readings_.ready(); }
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

  [[nodiscard]] Vector gyro_bias_radps() const { return filter().bias(); }
  [[nodiscard]] Vector gyro_bias_sigma_radps() const {
    const auto& p = filter().covariance();
    return Vector(p(3, 3), p(4, 4), p(5, 5)).cwiseSqrt();
  }
  [[nodiscard]] T magnetometer_delay_s() const { return filter().delay(); }
  [[nodiscard]] bool at_rest() const { return readings_.level().at_rest(); }

  /// Sets the heading: direction of the body's x axis, clockwise from north.
  void set_compass(Angle x_axis, Angle sigma) { readings_.set_compass(x_axis, sigma); }

  /// External heading of AhrsParameters::heading_axis, up to AhrsParameters::heading_history_s old:
  /// corrects attitude and gyro bias. The first one initialises an unknown heading. `waiting`: no
  /// attitude at that time yet; `late`: older than the history, or not after the previous fix;
  /// `missing`: not finite, or variance not positive; `disturbed`: rejected by the gate.
  UpdateStatus add_heading(const HeadingFix& fix) { return readings_.add_heading(fix); }
  /// Rotation of that axis integrated from the gyro alone, counter-clockwise seen from above.
  [[nodiscard]] const HeadingTrack& heading_track() const { return readings_.external().track(); }

  [[nodiscard]] const AhrsReport& report() const { return readings_.report(); }
  /// Normalised innovation squared of the last readings, one degree of freedom each.
  [[nodiscard]] AhrsNis<T> nis() const {
    const auto& level = readings_.level().nis();
    return {level[0], level[1], readings_.heading().nis(), readings_.external().nis()};
  }

 private:
  [[nodiscard]] const AhrsFilter<T>& filter() const { return readings_.filter(); }
  [[nodiscard]] Covariance attitude_covariance() const {
    return filter().covariance().dense().template topLeftCorner<3, 3>();
  }

  AhrsReadings<T> readings_;
};

}  // namespace wayfare
