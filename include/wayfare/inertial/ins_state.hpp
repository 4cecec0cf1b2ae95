#pragma once

// State of inertial navigation with GNSS: Zhang 2020, section 3.1, with a unit quaternion and a
// three-dimensional attitude error.
//
// Motion constraints of a vehicle (non-holonomic, zero velocity, zero turn rate), and loosely
// coupled positions and velocities, one axis at a time.

#include <Eigen/Core>

#include <wayfare/core/geodesy.hpp>
#include <wayfare/core/manifold.hpp>
#include <wayfare/core/se3.hpp>
#include <wayfare/filter/sequential_update.hpp>

namespace wayfare {

/// The 23 error states, in this order.
namespace ins_state {
inline constexpr int kPosition = 0;     ///< north, east, down, m
inline constexpr int kVelocity = 3;     ///< north, east, down, m/s
inline constexpr int kAttitude = 6;     ///< rotation vector in the unit's axes, rad (right)
inline constexpr int kGyroBias = 9;     ///< rad/s
inline constexpr int kAccelBias = 12;   ///< m/s²
inline constexpr int kGyroScale = 15;   ///< 1
inline constexpr int kAccelScale = 18;  ///< 1
inline constexpr int kClock = 21;       ///< receiver clock bias (m) and drift (m/s)
inline constexpr int kSize = 23;
}  // namespace ins_state

/// `position_m` is on a LocalTangentPlane; `q_nu` rotates the unit's axes to local level. `Offsets`
/// inter-system clock offsets (m) follow the receiver clock.
template <class T, int Offsets = 0>
struct InsState {
  using Scalar = T;
  static constexpr int kDof = ins_state::kSize + Offsets;
  static constexpr int kOffsets = Offsets;
  using Vector3 = Eigen::Matrix<T, 3, 1>;
  using Tangent = Eigen::Matrix<T, kDof, 1>;

  Vector3 position_m = Vector3::Zero();
  Vector3 velocity_mps = Vector3::Zero();
  SO3<T> q_nu;
  Vector3 gyro_bias_radps = Vector3::Zero();
  Vector3 accel_bias_mps2 = Vector3::Zero();
  Vector3 gyro_scale = Vector3::Zero();
  Vector3 accel_scale = Vector3::Zero();
  /// Bias (m) and drift (m/s) of the receiver's clock, then the offsets (m).
  Eigen::Matrix<T, 2 + Offsets, 1> clock = Eigen::Matrix<T, 2 + Offsets, 1>::Zero();

  [[nodiscard]] InsState plus(const Tangent& tau) const {
    using namespace ins_state;
    InsState y;
    y.position_m = position_m + tau.template segment<3>(kPosition);
    y.velocity_mps = velocity_mps + tau.template segment<3>(kVelocity);
    y.q_nu = q_nu.plus(tau.template segment<3>(kAttitude));
    y.gyro_bias_radps = gyro_bias_radps + tau.template segment<3>(kGyroBias);
    y.accel_bias_mps2 = accel_bias_mps2 + tau.template segment<3>(kAccelBias);
    y.gyro_scale = gyro_scale + tau.template segment<3>(kGyroScale);
    y.accel_scale = accel_scale + tau.template segment<3>(kAccelScale);
    y.clock = clock + tau.template tail<2 + Offsets>();
    return y;
  }

  [[nodiscard]] Tangent minus(const InsState& x) const {
    Tangent tau;
    tau << position_m - x.position_m, velocity_mps - x.velocity_mps, q_nu.minus(x.q_nu),
        gyro_bias_radps - x.gyro_bias_radps, accel_bias_mps2 - x.accel_bias_mps2,
        gyro_scale - x.gyro_scale, accel_scale - x.accel_scale, clock - x.clock;
    return tau;
  }

  /// The same in another scalar type; broadcast to every lane of a pack.
  template <class U>
  [[nodiscard]] InsState<U, Offsets> cast() const {
    InsState<U, Offsets> y;
    y.position_m = position_m.template cast<U>();
    y.velocity_mps = velocity_mps.template cast<U>();
    y.q_nu = q_nu.template cast<U>();
    y.gyro_bias_radps = gyro_bias_radps.template cast<U>();
    y.accel_bias_mps2 = accel_bias_mps2.template cast<U>();
    y.gyro_scale = gyro_scale.template cast<U>();
    y.accel_scale = accel_scale.template cast<U>();
    y.clock = clock.template cast<U>();
    return y;
  }
};

/// The velocity of a point of the vehicle along one of its directions is `speed_mps` (zero: a
/// non-holonomic constraint). Direction and lever arm in the unit's axes, lever from the unit.
template <class T, int Offsets = 0>
struct BodyVelocityModel {
  using Vector3 = Eigen::Matrix<T, 3, 1>;
  Vector3 direction, lever_m, gyro_radps;
  T speed_mps, variance;

  using Row = SparseRow<T, 9>;
  [[nodiscard]] ScalarMeasurement<T, Row> operator()(const InsState<T, Offsets>& x) const {
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
  int axis;
  T velocity_mps, variance;

  using Row = SparseRow<T, 1>;
  [[nodiscard]] ScalarMeasurement<T, Row> operator()(const InsState<T, Offsets>& x) const {
    return {velocity_mps - x.velocity_mps[axis], {{ins_state::kVelocity + axis}, {T(1)}}, variance};
  }
};

/// At standstill a gyro reads its bias and the Earth's rotation (7e-5 rad/s, covered by the
/// variance: below the bias stability of any unit that needs this).
template <class T, int Offsets = 0>
struct ZeroTurnRateModel {
  int axis;
  T gyro_radps, variance;

  using Row = SparseRow<T, 1>;
  [[nodiscard]] ScalarMeasurement<T, Row> operator()(const InsState<T, Offsets>& x) const {
    return {
        gyro_radps - x.gyro_bias_radps[axis], {{ins_state::kGyroBias + axis}, {T(1)}}, variance};
  }
};

/// The antenna's position along `direction` (local level), as computed by a GNSS receiver.
template <class T, int Offsets = 0>
struct AntennaPositionModel {
  using Vector3 = Eigen::Matrix<T, 3, 1>;
  const LocalTangentPlane& plane;
  Vector3 position_m;  ///< on the tangent plane
  Vector3 direction, lever_m;
  T variance;

  using Row = SparseRow<T, 6>;
  [[nodiscard]] ScalarMeasurement<T, Row> operator()(const InsState<T, Offsets>& x) const {
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
  using Vector3 = Eigen::Matrix<T, 3, 1>;
  Vector3 velocity_mps, direction, lever_m, gyro_radps;
  T variance;

  using Row = SparseRow<T, 6>;
  [[nodiscard]] ScalarMeasurement<T, Row> operator()(const InsState<T, Offsets>& x) const {
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
