#pragma once

// Strapdown mechanisation over the rotating ellipsoid, second order in the step for signals that
// change linearly within it (coning and sculling included). Savage 1998, parts 1 and 2; Groves
// 2013, section 5.4.
//
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
#include <wayfare/sensors/measurements.hpp>

namespace wayfare {

/// Two readings and the time between them.
struct ImuInterval {
  Eigen::Vector3d begin_rate_radps, end_rate_radps;
  Eigen::Vector3d begin_force_mps2, end_force_mps2;
  double dt_s = 0.0;
};

[[nodiscard]] inline ImuInterval between(const ImuSample& begin, const ImuSample& end) {
  return {begin.angular_rate_radps, end.angular_rate_radps, begin.specific_force_mps2,
          end.specific_force_mps2, to_seconds(end.time - begin.time)};
}

/// Integrated rotation and velocity change over an interval, corrected for sensor errors, in the
/// unit's axes at the beginning.
template <class T>
struct InertialIncrement {
  Eigen::Matrix<T, 3, 1> rotation_rad;     ///< rotation vector
  Eigen::Matrix<T, 3, 1> velocity_mps;     ///< integral of the specific force
  Eigen::Matrix<T, 3, 1> mean_rate_radps;  ///< relative to inertial space
  Eigen::Matrix<T, 3, 1> mean_force_mps2;
};

/// Integrates rates and forces that change linearly from begin to end, to second order: θ = T(ω₀ +
/// ω₁)/2 + T²/12 ω₀ × ω₁ and v = T(f₀ + f₁)/2 + ∫θ × f.
template <class T>
[[nodiscard]] InertialIncrement<T> integrate(const Eigen::Matrix<T, 3, 1>& w0,
                                             const Eigen::Matrix<T, 3, 1>& w1,
                                             const Eigen::Matrix<T, 3, 1>& f0,
                                             const Eigen::Matrix<T, 3, 1>& f1, const T& dt) {
  InertialIncrement<T> i;
  i.mean_rate_radps = T(0.5) * (w0 + w1);
  i.mean_force_mps2 = T(0.5) * (f0 + f1);
  const T t2 = dt * dt;
  i.rotation_rad = dt * i.mean_rate_radps + (t2 / T(12)) * w0.cross(w1);
  const Eigen::Matrix<T, 3, 1> with_begin = T(3.0 / 24) * f0 + T(5.0 / 24) * f1;
  const Eigen::Matrix<T, 3, 1> with_end = T(1.0 / 24) * f0 + T(3.0 / 24) * f1;
  i.velocity_mps = dt * i.mean_force_mps2 + t2 * (w0.cross(with_begin) + w1.cross(with_end));
  return i;
}

/// Earth rate and transport rate (Groves 2013, (5.41), (5.44)), rad/s, in local level axes.
template <class T>
struct LevelRates {
  Eigen::Matrix<T, 3, 1> earth, transport;
};
template <class T>
[[nodiscard]] LevelRates<T> level_rates(const EarthAt<T>& at, const Eigen::Matrix<T, 3, 1>& v) {
  const T rate = T(wgs84::kEarthRate_radps);
  const T east_turn = v[1] / at.transverse_m;
  return {{rate * at.cos_latitude, T(0), -rate * at.sin_latitude},
          {east_turn, -v[0] / at.meridian_m, -east_turn * at.sin_latitude / at.cos_latitude}};
}

/// Position on the tangent plane, velocity and attitude of an inertial unit.
template <class T>
struct Navigation {
  Eigen::Matrix<T, 3, 1> position_m;
  Eigen::Matrix<T, 3, 1> velocity_mps;
  SO3<T> q_nu;
};

/// One step: Zhang 2020, section 3.1; the attitude is updated first, by the measured rotation and
/// that of the local level.
template <class T>
[[nodiscard]] Navigation<T> strapdown_step(const Navigation<T>& x, const EarthAt<T>& at,
                                           const InertialIncrement<T>& measured, const T& dt) {
  using Vector3 = Eigen::Matrix<T, 3, 1>;
  const LevelRates<T> rates = level_rates(at, x.velocity_mps);
  const Vector3 level_turn = dt * (rates.earth + rates.transport);
  Navigation<T> y;
  y.q_nu = x.q_nu * SO3<T>::exp(measured.rotation_rad - x.q_nu.inverse() * level_turn);
  const Vector3 impulse = x.q_nu * measured.velocity_mps;
  const Vector3 coriolis = (T(2) * rates.earth + rates.transport).cross(x.velocity_mps);
  y.velocity_mps = x.velocity_mps + impulse - T(0.5) * level_turn.cross(impulse) - dt * coriolis;
  y.velocity_mps[2] += dt * at.gravity_mps2;
  const Vector3 travelled = (T(0.5) * dt) * (x.velocity_mps + y.velocity_mps);
  y.position_m = x.position_m +
                 Vector3(at.north_scale * travelled[0], at.east_scale * travelled[1], travelled[2]);
  return y;
}

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
