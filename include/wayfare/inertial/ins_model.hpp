#pragma once

// Navigation with one vertical gyro and wheel odometry (Liu, Atia, Karamat and Noureldin 2015,
// section 3.1): in latitude and longitude, and in a local plane. The gyro's axis points up
// (counter-clockwise positive); azimuth is clockwise from north.
//
// Process model of the 23-state filter: strapdown navigation, Gauss-Markov sensor errors, receiver
// clock.

#include <cmath>
#include <limits>

#include <Eigen/Core>

#include <wayfare/core/geodesy.hpp>
#include <wayfare/core/se2.hpp>
#include <wayfare/filter/gauss_markov.hpp>
#include <wayfare/inertial/detail/ins_transition.hpp>
#include <wayfare/inertial/imu_noise.hpp>
#include <wayfare/inertial/ins_state.hpp>

namespace wayfare {

/// Geodetic position and azimuth of a vehicle.
struct GeodeticHeading {
  Geodetic position;
  Angle azimuth;  ///< clockwise from north
};

/// Earth rate and transport rate measured by an upward gyro (1), rad/s.
[[nodiscard]] inline double level_rate_rad_s(const Geodetic& at, double east_speed_m_s) {
  const double s = std::sin(at.latitude.radians());
  return wgs84::kEarthRate_radps * s +
         east_speed_m_s * std::tan(at.latitude.radians()) / (transverse_radius_m(s) + at.height_m);
}

/// (1) to (5) over `dt_s` at constant turn rate and forward speed; `turn_rate_rad_s` is the gyro
/// reading less its bias. Midpoint heading: second order.
[[nodiscard]] inline GeodeticHeading advance(const GeodeticHeading& from, double turn_rate_rad_s,
                                             double speed_m_s, double dt_s) {
  const double a0 = from.azimuth.radians();
  const double level = level_rate_rad_s(from.position, speed_m_s * std::sin(a0));
  const double a1 = a0 - (turn_rate_rad_s - level) * dt_s, middle = 0.5 * (a0 + a1);
  const double s = std::sin(from.position.latitude.radians()), h = from.position.height_m;
  const double north = speed_m_s * std::cos(middle) * dt_s / (meridian_radius_m(s) + h);
  const double east = speed_m_s * std::sin(middle) * dt_s /
                      ((transverse_radius_m(s) + h) * std::cos(from.position.latitude.radians()));
  return {{from.position.latitude + Angle::radians(north),
           from.position.longitude + Angle::radians(east), h},
          Angle::radians(a1).wrapped()};
}

/// The same in a plane, along the arc. `turn_rate_rad_s` is also less the Earth and transport rate.
[[nodiscard]] inline SE2d advance(const SE2d& from, double turn_rate_rad_s, double speed_m_s,
                                  double dt_s) {
  return from.plus({speed_m_s * dt_s, 0.0, turn_rate_rad_s * dt_s});
}

/// A local plane on the Earth: its origin and the azimuth of its x axis.
struct LocalPlane {
  Geodetic origin;
  Angle azimuth_of_x;

  [[nodiscard]] GeodeticHeading geodetic(const SE2d& pose) const {
    const double a = azimuth_of_x.radians(), c = std::cos(a), s = std::sin(a);
    // x points along the azimuth, y to its left.
    const Eigen::Vector3d ned(c * pose.x() + s * pose.y(), s * pose.x() - c * pose.y(), 0.0);
    return {geodetic_from_ned(ned, origin), (azimuth_of_x - pose.heading()).wrapped()};
  }
};

/// ImuNoise and ReceiverClockNoise in the filter's scalar, so that each lane of a pack may have its
/// own. Order of the twelve: gyro bias, accelerometer bias, gyro scale, accelerometer scale.
template <class T>
struct InsNoise {
  using Vector3 = Eigen::Matrix<T, 3, 1>;
  Eigen::Matrix<T, 12, 1> sigma, tau_s;
  Vector3 gyro_white, accel_white;
  T clock_bias_walk, clock_drift_walk;
  /// Random walk of the inter-system clock offsets, m/√s.
  T clock_offset_walk = T(0.01);

  InsNoise() = default;
  InsNoise(const ImuNoise& imu, const ReceiverClockNoise& clock)
      : gyro_white(imu.gyro_white_rad_per_sqrt_s.template cast<T>()),
        accel_white(imu.accel_white_mps_per_sqrt_s.template cast<T>()),
        clock_bias_walk(clock.bias_walk_m_per_sqrt_s),
        clock_drift_walk(clock.drift_walk_mps_per_sqrt_s) {
    sigma << imu.gyro_bias_radps.sigma.template cast<T>(),
        imu.accel_bias_mps2.sigma.template cast<T>(), imu.gyro_scale.sigma.template cast<T>(),
        imu.accel_scale.sigma.template cast<T>();
    tau_s << imu.gyro_bias_radps.tau_s.template cast<T>(),
        imu.accel_bias_mps2.tau_s.template cast<T>(), imu.gyro_scale.tau_s.template cast<T>(),
        imu.accel_scale.tau_s.template cast<T>();
  }
};

/// Predicted state and transition of one step.
template <class T, int Offsets = 0>
struct InsStep {
  InsState<T, Offsets> state;
  InsTransition<T, Offsets> transition;

  template <class Square>
  void propagate(Square& p) const {
    transition.propagate(p);
  }
};

/// ω = (ω̃ − b)/(1 + s), element by element (Zhang 2020, section 3.1).
template <class T>
struct CorrectedImu {
  using Vector3 = Eigen::Matrix<T, 3, 1>;
  Vector3 inverse_gyro_scale, inverse_accel_scale;
  Vector3 begin_rate, end_rate, begin_force, end_force;

  template <int Offsets>
  CorrectedImu(const InsState<T, Offsets>& x, const ImuInterval& u)
      : inverse_gyro_scale((x.gyro_scale.array() + T(1)).inverse()),
        inverse_accel_scale((x.accel_scale.array() + T(1)).inverse()),
        begin_rate(rate(x, u.begin_rate_radps)),
        end_rate(rate(x, u.end_rate_radps)),
        begin_force(force(x, u.begin_force_mps2)),
        end_force(force(x, u.end_force_mps2)) {}

 private:
  template <class State>
  Vector3 rate(const State& x, const Eigen::Vector3d& measured) const {
    return (measured.cast<T>() - x.gyro_bias_radps).cwiseProduct(inverse_gyro_scale);
  }
  template <class State>
  Vector3 force(const State& x, const Eigen::Vector3d& measured) const {
    return (measured.cast<T>() - x.accel_bias_mps2).cwiseProduct(inverse_accel_scale);
  }
};

/// A ProcessModel with ImuInterval as input.
template <class T, int Offsets = 0>
class InsModel {
 public:
  using State = InsState<T, Offsets>;
  using Vector3 = Eigen::Matrix<T, 3, 1>;
  using Matrix3 = Eigen::Matrix<T, 3, 3>;

  InsModel(const LocalTangentPlane& plane, const InsNoise<T>& noise)
      : plane_(plane), noise_(noise) {}

  /// Precomputes the terms shared by steps of exactly this length. Results do not change.
  void prepare(double dt_s) {
    prepared_ = error_steps(T(dt_s));
    prepared_dt_s_ = dt_s;
  }

  [[nodiscard]] InsStep<T, Offsets> operator()(const State& x, const ImuInterval& u) const {
    const T dt = T(u.dt_s);
    const EarthAt<T> at = plane_.earth(x.position_m);
    const CorrectedImu<T> imu(x, u);
    const InertialIncrement<T> measured =
        integrate(imu.begin_rate, imu.end_rate, imu.begin_force, imu.end_force, dt);
    const Navigation<T> next =
        strapdown_step({x.position_m, x.velocity_mps, x.q_nu}, at, measured, dt);
    InsStep<T, Offsets> step{x, transition(x, at, imu, measured, u.dt_s)};
    step.state.position_m = next.position_m;
    step.state.velocity_mps = next.velocity_mps;
    step.state.q_nu = next.q_nu;
    decay(step.state, step.transition.kept, dt);
    return step;
  }

 private:
  static void decay(State& x, const Eigen::Matrix<T, 12, 1>& kept, const T& dt) {
    x.gyro_bias_radps.array() *= kept.template segment<3>(0).array();
    x.accel_bias_mps2.array() *= kept.template segment<3>(3).array();
    x.gyro_scale.array() *= kept.template segment<3>(6).array();
    x.accel_scale.array() *= kept.template segment<3>(9).array();
    x.clock[0] += dt * x.clock[1];
  }

  InsTransition<T, Offsets> transition(const State& x, const EarthAt<T>& at,
                                       const CorrectedImu<T>& imu,
                                       const InertialIncrement<T>& measured, double dt_s) const {
    const T dt = T(dt_s);
    InsTransition<T, Offsets> f;
    f.dt_s = dt;
    f.half_dt = T(0.5) * dt * Vector3(at.north_scale, at.east_scale, T(1));
    const LevelRates<T> rates = level_rates(at, x.velocity_mps);
    f.velocity_turn = -dt * (T(2) * rates.earth + rates.transport);
    const Matrix3 c = x.q_nu.matrix();
    f.velocity_attitude = -c * skew(measured.velocity_mps);
    f.velocity_accel_bias = c * (-dt * imu.inverse_accel_scale).asDiagonal();
    f.scale_force = beyond_noise(measured.mean_force_mps2, noise_.accel_white, 3, dt);
    const Vector3 rotation =
        measured.rotation_rad - c.transpose() * Vector3(dt * (rates.earth + rates.transport));
    const Matrix3 k = skew(rotation);
    f.attitude_attitude = Matrix3::Identity() - k + T(0.5) * k * k;
    f.attitude_gyro_bias = -dt * imu.inverse_gyro_scale;
    f.attitude_gyro_scale = f.attitude_gyro_bias.cwiseProduct(
        beyond_noise(measured.mean_rate_radps, noise_.gyro_white, 0, dt));
    noise(f, c, dt_s);
    return f;
  }

  /// Regressor of the scale: zero if noise and bias alone explain the reading. A regressor with
  /// measurement noise biases its coefficient (Fuller 1987, section 1.1), here the scale of rarely
  /// excited axes, over hours by many times its estimated standard deviation.
  Vector3 beyond_noise(const Vector3& measured, const Vector3& white, int bias, const T& dt) const {
    constexpr double kSigmas = 3.0;
    Vector3 beyond;
    for (int i = 0; i < 3; ++i) {
      const T variance = white[i] * white[i] / dt + noise_.sigma[bias + i] * noise_.sigma[bias + i];
      const MaskOf<T> significant = measured[i] * measured[i] > T(kSigmas * kSigmas) * variance;
      beyond[i] = select(significant, measured[i], T(0));
    }
    return beyond;
  }

  /// The twelve sensor errors and the receiver clock over a step.
  struct ErrorSteps {
    Eigen::Matrix<T, 12, 1> kept = Eigen::Matrix<T, 12, 1>::Zero();
    Eigen::Matrix<T, 12, 1> noise = Eigen::Matrix<T, 12, 1>::Zero();
    ClockStep<T> clock{};
  };
  ErrorSteps error_steps(const T& dt) const {
    ErrorSteps steps;
    for (int i = 0; i < 12; ++i) {
      const ProcessStep1<T> step = discretise_gauss_markov(noise_.sigma[i], noise_.tau_s[i], dt);
      steps.kept[i] = step.phi;
      steps.noise[i] = step.q;
    }
    steps.clock = discretise_clock(noise_.clock_bias_walk, noise_.clock_drift_walk, dt);
    return steps;
  }

  void noise(InsTransition<T, Offsets>& f, const Matrix3& c, double dt_s) const {
    const T dt = T(dt_s);
    const Vector3 accel = dt * noise_.accel_white.cwiseAbs2();
    f.velocity_noise = c * accel.asDiagonal() * c.transpose();
    f.attitude_noise = dt * noise_.gyro_white.cwiseAbs2();
    const ErrorSteps steps = dt_s == prepared_dt_s_ ? prepared_ : error_steps(dt);
    f.kept = steps.kept;
    f.error_noise = steps.noise;
    f.clock_noise = steps.clock;
    f.clock_offset_noise = noise_.clock_offset_walk * noise_.clock_offset_walk * dt;
  }

  LocalTangentPlane plane_;
  InsNoise<T> noise_;
  double prepared_dt_s_ = std::numeric_limits<double>::quiet_NaN();
  ErrorSteps prepared_;
};

}  // namespace wayfare
