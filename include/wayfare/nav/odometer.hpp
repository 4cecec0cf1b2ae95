#pragma once

// Wheel speeds as measurements of inertial navigation, with the scale of the wheels, the direction
// of travel and the place of the axle as states (Wu, Wu and Hu 2009, "Self-calibration for land
// navigation using inertial sensors and odometer"; Groves 2013, section 16.3).

#include <Eigen/Core>

#include <wayfare/core/se3.hpp>
#include <wayfare/filter/blocks.hpp>
#include <wayfare/filter/sequential_update.hpp>
#include <wayfare/inertial/ins_state.hpp>

namespace wayfare {

/// Wheels of a vehicle, and what is known of them.
struct OdometerOptions {
  double speed_sigma_mps = 0.1;         ///< of a reading, at ten readings a second
  double scale_sigma = 0.03;            ///< of the relative error of the speeds
  double scale_walk_per_sqrt_s = 1e-5;  ///< its random walk
  /// Of the direction of travel relative to the body's forward axis, pitch and yaw.
  double direction_sigma_rad = 0.02;
  /// From the unit to the middle of the axle that does not steer, body axes, m.
  Eigen::Vector3d lever_arm_m = Eigen::Vector3d::Zero();
  double lever_arm_sigma_m = 1.0;  ///< of each component; zero: known
  /// Readings with a normalised innovation above this, σ, are rejected: the wheels slip. Those that
  /// stay rejected for GnssInsOptions::gate_reopen_s are used again, with inflated uncertainty.
  double gate_sigma = 3.5;
  /// Of the velocity of the axle across the direction of travel, with four satellites or more;
  /// GnssInsOptions::non_holonomic_sigma_mps with fewer. Zero: only with fewer.
  double cross_sigma_mps = 0.1;
};

/// What the filter has learnt of the wheels.
struct OdometerEstimate {
  double scale = 0.0;                                       ///< relative error of the speeds
  Eigen::Vector2d direction_rad = Eigen::Vector2d::Zero();  ///< pitch and yaw of the travel
  Eigen::Vector3d lever_arm_m = Eigen::Vector3d::Zero();    ///< from unit to axle, body axes
  /// Standard deviations: scale, pitch, yaw, lever arm.
  Eigen::Matrix<double, 6, 1> sigma = Eigen::Matrix<double, 6, 1>::Zero();
};

namespace ins {

/// Scale of the wheels, pitch and yaw of the direction of travel, lever arm to the axle.
template <class T>
struct Odometer : RandomWalk<6, T> {
  using RandomWalk<6, T>::RandomWalk;
  using Value = Eigen::Matrix<T, 6, 1>;  ///< relative, rad, rad, m, m, m
  /// Member of states.
  struct Storage {
    Value odometer = Value::Zero();  ///< relative, rad, rad, m, m, m
  };
  static constexpr auto kMember = &Storage::odometer;  ///< where states keep it
  static constexpr BlockNames<6> kNames{"odometer scale",    "travel pitch",
                                        "travel yaw",        "axle forward",
                                        "axle to the right", "axle down"};  ///< of
                                                                            ///< its errors
};

}  // namespace ins

/// Velocity of the axle along one axis of travel: (1 + k)(v − μ × v)·e₁ is the speed of the wheels,
/// and (v − μ × v)·e₂ and ·e₃ are about zero, with v = R(q⁻¹ v_n) + (R ω) × l in body axes, scale
/// k, small angles μ = (0, pitch, yaw) and lever arm l of the state.
template <class T, int Offsets = 0>
struct AxleVelocityModel {
  using Vector3 = Eigen::Matrix<T, 3, 1>;  ///< of three components
  int axis;                                ///< 0 forward, 1 to the right, 2 down
  T speed_mps,                             ///< along the axis; zero across
      variance;                            ///< (m/s)²
  Eigen::Matrix<T, 3, 3> body_unit;        ///< the unit's axes to the body's
  Vector3 gyro_radps;                      ///< measured rate, the unit's axes
  using Row = SparseRow<T, 15>;            ///< nonzero numbers of H
  /// Innovation, row and variance at a state.
  template <class... Further>
  [[nodiscard]] ScalarMeasurement<T, Row> operator()(
      const InsState<T, Offsets, Further...>& x) const {
    constexpr int k = InsState<T, Offsets, Further...>::template index<ins::Odometer<T>>();
    const Vector3 e = Vector3::Unit(axis), travel(T(0), x.odometer[1], x.odometer[2]);
    const Vector3 lever = x.odometer.template tail<3>();
    const Vector3 inverse_scale = (x.gyro_scale.array() + T(1)).inverse();
    const Vector3 rate =
        body_unit * Vector3((gyro_radps - x.gyro_bias_radps).cwiseProduct(inverse_scale));
    const Vector3 unit_mps = x.q_nu.inverse() * x.velocity_mps;
    const Vector3 v = body_unit * unit_mps + rate.cross(lever);
    const T factor = axis == 0 ? T(1) + x.odometer[0] : T(1);
    // (v − μ × v)·e = v·a.
    const Vector3 a = factor * (e + travel.cross(e));
    const Vector3 a_unit = body_unit.transpose() * a;
    const Vector3 by_velocity = x.q_nu * a_unit, by_attitude = a_unit.cross(unit_mps);
    const Vector3 by_bias = (body_unit.transpose() * a.cross(lever)).cwiseProduct(inverse_scale);
    const Vector3 by_lever = a.cross(rate), by_travel = factor * e.cross(v);
    const T predicted = a.dot(v);
    return {
        speed_mps - predicted,
        {{3, 4, 5, 6, 7, 8, 9, 10, 11, k, k + 1, k + 2, k + 3, k + 4, k + 5},
         {by_velocity[0], by_velocity[1], by_velocity[2], by_attitude[0], by_attitude[1],
          by_attitude[2], by_bias[0], by_bias[1], by_bias[2], axis == 0 ? predicted / factor : T(0),
          by_travel[1], by_travel[2], by_lever[0], by_lever[1], by_lever[2]}},
        variance};
  }
};

}  // namespace wayfare
