#pragma once

// Strapdown mechanisation over the rotating ellipsoid, second order in the step for signals that
// change linearly within it (coning and sculling included). Savage 1998, parts 1 and 2; Groves
// 2013, section 5.4.

#include <Eigen/Core>

#include <wayfare/core/geodesy.hpp>
#include <wayfare/core/se3.hpp>
#include <wayfare/sensors/imu.hpp>

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

}  // namespace wayfare
