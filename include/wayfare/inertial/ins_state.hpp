#pragma once

// Strapdown mechanisation over the rotating ellipsoid, second order in the step for signals that
// change linearly within it (coning and sculling included). Savage 1998, parts 1 and 2; Groves
// 2013, section 5.4.
// State of inertial navigation with GNSS: Zhang 2020, section 3.1, with a unit quaternion and a
// three-dimensional attitude error.

#include <Eigen/Core>

#include <wayfare/core/detail/eigen_alignment.hpp>
#include <wayfare/core/geodesy.hpp>
#include <wayfare/core/manifold.hpp>
#include <wayfare/core/se3.hpp>
#include <wayfare/filter/blocks.hpp>
#include <wayfare/filter/state.hpp>
#include <wayfare/sensors/measurements.hpp>

namespace wayfare {

/// Two readings and the time between them.
struct ImuInterval {
  Eigen::Vector3d begin_rate_radps,  ///< rad/s, first reading
      end_rate_radps;                ///< rad/s, second
  Eigen::Vector3d begin_force_mps2,  ///< m/s², first reading
      end_force_mps2;                ///< m/s², second
  double dt_s = 0.0;                 ///< between the readings
};

/// The interval of two samples.
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
  Eigen::Matrix<T, 3, 1> mean_force_mps2;  ///< specific force, m/s²
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
  Eigen::Matrix<T, 3, 1> earth,  ///< of the Earth's axes
      transport;                 ///< of the local level over the Earth
};
/// At a velocity `v` north, east, down, m/s.
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
  Eigen::Matrix<T, 3, 1> position_m;    ///< on the tangent plane
  Eigen::Matrix<T, 3, 1> velocity_mps;  ///< north, east, down
  SO3<T> q_nu;                          ///< unit to local level
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

/// The blocks of InsState.
namespace ins {

/// Position on a LocalTangentPlane: north, east, down, m.
template <class T>
struct Position {
  using Value = Eigen::Matrix<T, 3, 1>;  ///< m
  /// Member of states.
  struct Storage {
    Value position_m = Value::Zero();  ///< north, east, down, m
  };
  static constexpr auto kMember = &Storage::position_m;  ///< where states keep it
  /// Names of its errors.
  static constexpr BlockNames<3> kNames{"position north", "position east", "position down"};
};

/// Velocity north, east, down, m/s.
template <class T>
struct Velocity {
  using Value = Eigen::Matrix<T, 3, 1>;  ///< m/s
  /// Member of states.
  struct Storage {
    Value velocity_mps = Value::Zero();  ///< north, east, down, m/s
  };
  static constexpr auto kMember = &Storage::velocity_mps;  ///< where states keep it
  /// Names of its errors.
  static constexpr BlockNames<3> kNames{"velocity north", "velocity east", "velocity down"};
};

/// Rotates the unit's axes to local level; error in the unit's axes, rad.
template <class T>
struct Attitude {
  using Value = SO3<T>;  ///< unit to local level
  /// Member of states.
  struct Storage {
    Value q_nu;  ///< unit to local level
  };
  static constexpr auto kMember = &Storage::q_nu;  ///< where states keep it
  /// Names of its errors.
  static constexpr BlockNames<3> kNames{"attitude x", "attitude y", "attitude z"};
};

/// Gyro bias, rad/s.
template <class T>
struct GyroBias : GaussMarkov<3, T> {
  using Value = Eigen::Matrix<T, 3, 1>;  ///< rad/s
  /// Member of states.
  struct Storage {
    Value gyro_bias_radps = Value::Zero();  ///< rad/s, the unit's axes
  };
  static constexpr auto kMember = &Storage::gyro_bias_radps;  ///< where states keep it
  /// Names of its errors.
  static constexpr BlockNames<3> kNames{"gyro bias x", "gyro bias y", "gyro bias z"};
};

/// Accelerometer bias, m/s².
template <class T>
struct AccelBias : GaussMarkov<3, T> {
  using Value = Eigen::Matrix<T, 3, 1>;  ///< m/s²
  /// Member of states.
  struct Storage {
    Value accel_bias_mps2 = Value::Zero();  ///< m/s², the unit's axes
  };
  static constexpr auto kMember = &Storage::accel_bias_mps2;  ///< where states keep it
  static constexpr BlockNames<3> kNames{"accelerometer bias x", "accelerometer bias y",
                                        "accelerometer bias z"};  ///< of its errors
};

/// Gyro scale error, relative.
template <class T>
struct GyroScale : GaussMarkov<3, T> {
  using Value = Eigen::Matrix<T, 3, 1>;  ///< per axis
  /// Member of states.
  struct Storage {
    Value gyro_scale = Value::Zero();  ///< relative, the unit's axes
  };
  static constexpr auto kMember = &Storage::gyro_scale;  ///< where states keep it
  /// Names of its errors.
  static constexpr BlockNames<3> kNames{"gyro scale x", "gyro scale y", "gyro scale z"};
};

/// Accelerometer scale error, relative.
template <class T>
struct AccelScale : GaussMarkov<3, T> {
  using Value = Eigen::Matrix<T, 3, 1>;  ///< per axis
  /// Member of states.
  struct Storage {
    Value accel_scale = Value::Zero();  ///< relative, the unit's axes
  };
  static constexpr auto kMember = &Storage::accel_scale;  ///< where states keep it
  static constexpr BlockNames<3> kNames{"accelerometer scale x", "accelerometer scale y",
                                        "accelerometer scale z"};  ///< of its errors
};

/// Bias (m) and drift (m/s) of the receiver's clock, then inter-system offsets (m).
template <class T, int Offsets>
struct Clock : ReceiverClockBlock<Offsets, T> {
  static_assert(Offsets <= 5);
  using Value = Eigen::Matrix<T, 2 + Offsets, 1>;  ///< bias, drift, offsets
  /// Member of states.
  struct Storage {
    Value clock = Value::Zero();  ///< m, m/s, then m
  };
  static constexpr auto kMember = &Storage::clock;  ///< where states keep it
  /// Names of its errors.
  static constexpr BlockNames<2 + Offsets> kNames = [] {
    constexpr BlockNames<7> kAll{"clock bias",     "clock drift",    "clock offset 1",
                                 "clock offset 2", "clock offset 3", "clock offset 4",
                                 "clock offset 5"};
    BlockNames<2 + Offsets> names;
    for (std::size_t i = 0; i < names.size(); ++i) names[i] = kAll[i];
    return names;
  }();
};

}  // namespace ins

/// Members `position_m`, `velocity_mps`, `q_nu`, `gyro_bias_radps`, `accel_bias_mps2`,
/// `gyro_scale`, `accel_scale` and `clock`; 23 errors without `Offsets`. Further blocks follow.
template <class T, int Offsets = 0, class... Further>
using InsState =
    State<ins::Position<T>, ins::Velocity<T>, ins::Attitude<T>, ins::GyroBias<T>, ins::AccelBias<T>,
          ins::GyroScale<T>, ins::AccelScale<T>, ins::Clock<T, Offsets>, Further...>;

/// Places of the errors in the tangent of InsState.
namespace ins_state {
using Plain = InsState<double>;  ///< of double, without offsets
inline constexpr int kPosition = Plain::index<ins::Position<double>>();  ///< north, east, down
inline constexpr int kVelocity = Plain::index<ins::Velocity<double>>();  ///< north, east, down
inline constexpr int kAttitude = Plain::index<ins::Attitude<double>>();  ///< about the unit's axes
inline constexpr int kGyroBias = Plain::index<ins::GyroBias<double>>();  ///< of three
inline constexpr int kAccelBias = Plain::index<ins::AccelBias<double>>();    ///< of three
inline constexpr int kGyroScale = Plain::index<ins::GyroScale<double>>();    ///< of three
inline constexpr int kAccelScale = Plain::index<ins::AccelScale<double>>();  ///< of three
inline constexpr int kClock = Plain::index<ins::Clock<double, 0>>();         ///< bias, then drift
inline constexpr int kSize = Plain::kDof;                                    ///< number of errors
}  // namespace ins_state

}  // namespace wayfare
