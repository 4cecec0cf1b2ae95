#pragma once

// Measurements of InsState, one axis at a time: motion constraints of a vehicle (non-holonomic,
// zero velocity, zero turn rate), and loosely coupled positions and velocities.

#include <Eigen/Core>

#include <wayfare/core/detail/eigen_alignment.hpp>
#include <wayfare/core/geodesy.hpp>
#include <wayfare/filter/sequential_update.hpp>
#include <wayfare/inertial/ins_state.hpp>

namespace wayfare {

/// The velocity of a point of the vehicle along one of its directions is `speed_mps` (zero: a
/// non-holonomic constraint). Direction and lever arm in the unit's axes, lever from the unit.
template <class T, int Offsets = 0>
struct BodyVelocityModel {
  using Vector3 = Eigen::Matrix<T, 3, 1>;  ///< of three components
  Vector3 direction,                       ///< unit vector
      lever_m,                             ///< from the unit to the point
      gyro_radps;                          ///< measured rate
  T speed_mps,                             ///< along the direction
      variance;                            ///< of the speed, (m/s)²
  using Row = SparseRow<T, 9>;             ///< nonzero numbers of H
  /// Innovation, row and variance at a state, an InsState.
  [[nodiscard]] ScalarMeasurement<T, Row> operator()(const auto& x) const {
    const Vector3 inverse_scale = (x.gyro_scale.array() + T(1)).inverse();
    const Vector3 rate = (gyro_radps - x.gyro_bias_radps).cwiseProduct(inverse_scale);
    const Vector3 v_unit = x.q_nu.inverse() * x.velocity_mps;
    const Vector3 by_velocity = x.q_nu * direction;
    const Vector3 by_attitude = direction.cross(v_unit);
    const Vector3 by_bias = direction.cross(lever_m).cwiseProduct(inverse_scale);
    return {speed_mps - direction.dot(v_unit + rate.cross(lever_m)),
            {{3, 4, 5, 6, 7, 8, 9, 10, 11},
             {by_velocity[0], by_velocity[1], by_velocity[2], by_attitude[0], by_attitude[1],
              by_attitude[2], by_bias[0], by_bias[1], by_bias[2]}},
            variance};
  }
};

/// Velocity over the Earth along north, east or down (`axis`) is `velocity_mps`.
template <class T, int Offsets = 0>
struct VelocityModel {
  int axis;                     ///< 0 north, 1 east, 2 down
  T velocity_mps,               ///< measured
      variance;                 ///< (m/s)²
  using Row = SparseRow<T, 1>;  ///< nonzero number of H
  /// Innovation, row and variance at a state, an InsState.
  [[nodiscard]] ScalarMeasurement<T, Row> operator()(const auto& x) const {
    return {velocity_mps - x.velocity_mps[axis], {{ins_state::kVelocity + axis}, {T(1)}}, variance};
  }
};

/// At standstill a gyro reads its bias and the Earth's rotation (7e-5 rad/s, covered by the
/// variance: below the bias stability of any unit that needs this).
template <class T, int Offsets = 0>
struct ZeroTurnRateModel {
  int axis;                     ///< 0 x, 1 y, 2 z of the unit
  T gyro_radps,                 ///< measured
      variance;                 ///< (rad/s)²
  using Row = SparseRow<T, 1>;  ///< nonzero number of H
  /// Innovation, row and variance at a state, an InsState.
  [[nodiscard]] ScalarMeasurement<T, Row> operator()(const auto& x) const {
    return {
        gyro_radps - x.gyro_bias_radps[axis], {{ins_state::kGyroBias + axis}, {T(1)}}, variance};
  }
};

/// The antenna's position along `direction` (local level), as computed by a GNSS receiver.
template <class T, int Offsets = 0>
struct AntennaPositionModel {
  using Vector3 = Eigen::Matrix<T, 3, 1>;  ///< of three components
  const LocalTangentPlane& plane;          ///< of the state's positions; must outlive this
  Vector3 position_m;                      ///< on the tangent plane
  Vector3 direction,                       ///< unit vector
      lever_m;                             ///< the unit's axes
  T variance;                              ///< m²
  using Row = SparseRow<T, 6>;             ///< nonzero numbers of H
  /// Innovation, row and variance at a state, an InsState.
  [[nodiscard]] ScalarMeasurement<T, Row> operator()(const auto& x) const {
    const EarthAt<T> at = plane.earth(x.position_m);
    const Vector3 ground(T(1) / at.north_scale, T(1) / at.east_scale, T(1));
    const Vector3 by_position = direction.cwiseProduct(ground);
    const Vector3 by_attitude = lever_m.cross(Vector3(x.q_nu.inverse() * direction));
    return {direction.dot((position_m - x.position_m).cwiseProduct(ground) - x.q_nu * lever_m),
            {{0, 1, 2, 6, 7, 8},
             {by_position[0], by_position[1], by_position[2], by_attitude[0], by_attitude[1],
              by_attitude[2]}},
            variance};
  }
};

/// The antenna's velocity along `direction` (local level).
template <class T, int Offsets = 0>
struct AntennaVelocityModel {
  using Vector3 = Eigen::Matrix<T, 3, 1>;  ///< of three components
  Vector3 velocity_mps,                    ///< measured, local level
      direction,                           ///< unit vector
      lever_m,                             ///< the unit's axes
      gyro_radps;                          ///< measured rate, the unit's axes
  T variance;                              ///< (m/s)²
  using Row = SparseRow<T, 6>;             ///< nonzero numbers of H
  /// Innovation, row and variance at a state, an InsState.
  [[nodiscard]] ScalarMeasurement<T, Row> operator()(const auto& x) const {
    const Vector3 rate =
        (gyro_radps - x.gyro_bias_radps).cwiseQuotient(Vector3(x.gyro_scale.array() + T(1)));
    const Vector3 swing = rate.cross(lever_m);
    const Vector3 by_attitude = swing.cross(Vector3(x.q_nu.inverse() * direction));
    return {direction.dot(velocity_mps - x.velocity_mps - x.q_nu * swing),
            {{3, 4, 5, 6, 7, 8},
             {direction[0], direction[1], direction[2], by_attitude[0], by_attitude[1],
              by_attitude[2]}},
            variance};
  }
};

}  // namespace wayfare
