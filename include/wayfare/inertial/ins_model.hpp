#pragma once

// Navigation with one vertical gyro and wheel odometry (Liu, Atia, Karamat and Noureldin 2015,
// section 3.1): in latitude and longitude, and in a local plane. The gyro's axis points up
// (counter-clockwise positive); azimuth is clockwise from north.
//
// Process model of the 23-state filter: strapdown navigation, Gauss-Markov sensor errors, receiver
// clock.

#include <cmath>
#include <tuple>

#include <Eigen/Core>

#include <wayfare/core/geodesy.hpp>
#include <wayfare/core/se2.hpp>
#include <wayfare/filter/process.hpp>
#include <wayfare/inertial/detail/strapdown_jacobian.hpp>
#include <wayfare/inertial/imu_noise.hpp>
#include <wayfare/inertial/ins_state.hpp>

namespace wayfare {

/// Geodetic position and azimuth of a vehicle.
struct GeodeticHeading {
  Geodetic position;  ///< WGS-84
  Angle azimuth;      ///< clockwise from north
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
  Geodetic origin;     ///< where the plane touches the Earth
  Angle azimuth_of_x;  ///< clockwise from north

  /// Position and azimuth of a pose in the plane.
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
  using Vector3 = Eigen::Matrix<T, 3, 1>;  ///< of three axes
  Eigen::Matrix<T, 12, 1> sigma,           ///< stationary standard deviations
      tau_s;                               ///< correlation times
  Vector3 gyro_white,                      ///< rad/√s
      accel_white;                         ///< m/s/√s
  T clock_bias_walk,                       ///< m/√s
      clock_drift_walk;                    ///< m/s/√s
  /// Random walk of the inter-system clock offsets, m/√s.
  T clock_offset_walk = T(0.01);

  InsNoise() = default;
  /// The same for every lane.
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

/// ω = (ω̃ − b)/(1 + s), element by element (Zhang 2020, section 3.1).
template <class T>
struct CorrectedImu {
  using Vector3 = Eigen::Matrix<T, 3, 1>;  ///< of three axes
  Vector3 inverse_gyro_scale,              ///< 1/(1 + s) of the gyro
      inverse_accel_scale;                 ///< of the accelerometer
  Vector3 begin_rate,                      ///< rad/s, start
      end_rate,                            ///< rad/s, end
      begin_force,                         ///< m/s², start
      end_force;                           ///< m/s², end

  /// Of the readings of an interval.
  CorrectedImu(const Vector3& gyro_bias, const Vector3& accel_bias, const Vector3& gyro_scale,
               const Vector3& accel_scale, const ImuInterval& u)
      : inverse_gyro_scale((gyro_scale.array() + T(1)).inverse()),
        inverse_accel_scale((accel_scale.array() + T(1)).inverse()),
        begin_rate(corrected(u.begin_rate_radps, gyro_bias, inverse_gyro_scale)),
        end_rate(corrected(u.end_rate_radps, gyro_bias, inverse_gyro_scale)),
        begin_force(corrected(u.begin_force_mps2, accel_bias, inverse_accel_scale)),
        end_force(corrected(u.end_force_mps2, accel_bias, inverse_accel_scale)) {}

 private:
  static Vector3 corrected(const Eigen::Vector3d& measured, const Vector3& bias,
                           const Vector3& inverse_scale) {
    return (measured.cast<T>() - bias).cwiseProduct(inverse_scale);
  }
};

/// Moves position, velocity and attitude by inertial readings.
template <class T>
class Strapdown {
 public:
  using Vector3 = Eigen::Matrix<T, 3, 1>;  ///< of three axes
  using Matrix3 = Eigen::Matrix<T, 3, 3>;  ///< rotations and derivatives
  using Moves = BlockList<ins::Position<T>, ins::Velocity<T>, ins::Attitude<T>>;  ///< blocks moved
  /// Blocks they depend on.
  using By = BlockList<ins::Position<T>, ins::Velocity<T>, ins::Attitude<T>, ins::GyroBias<T>,
                       ins::AccelBias<T>, ins::GyroScale<T>, ins::AccelScale<T>>;

  /// The plane must outlive it.
  Strapdown(const LocalTangentPlane& plane, const InsNoise<T>& noise)
      : plane_(plane),
        gyro_white_(noise.gyro_white),
        accel_white_(noise.accel_white),
        gyro_sigma_(noise.sigma.template segment<3>(0)),
        accel_sigma_(noise.sigma.template segment<3>(3)) {}

  /// Moved, Jacobian and noise of one interval, as Process takes them.
  [[nodiscard]] auto step(const Vector3& position_m, const Vector3& velocity_mps,
                          const SO3<T>& q_nu, const Vector3& gyro_bias, const Vector3& accel_bias,
                          const Vector3& gyro_scale, const Vector3& accel_scale,
                          const ImuInterval& u) const {
    const T dt = T(u.dt_s);
    const EarthAt<T> at = plane_.earth(position_m);
    const CorrectedImu<T> imu(gyro_bias, accel_bias, gyro_scale, accel_scale, u);
    const InertialIncrement<T> measured =
        integrate(imu.begin_rate, imu.end_rate, imu.begin_force, imu.end_force, dt);
    const Navigation<T> next = strapdown_step({position_m, velocity_mps, q_nu}, at, measured, dt);
    const Matrix3 c = q_nu.matrix();
    const Vector3 accel = dt * accel_white_.cwiseAbs2();
    const Matrix3 velocity_noise = c * accel.asDiagonal() * c.transpose();
    const Vector3 attitude_noise = dt * gyro_white_.cwiseAbs2();
    return CoupledStep{std::tuple{next.position_m, next.velocity_mps, next.q_nu},
                       jacobian(level_rates(at, velocity_mps), at, c, imu, measured, dt),
                       std::tuple{NoNoise{}, velocity_noise, attitude_noise}};
  }

  /// Regressor of the scale: zero if noise and bias alone explain the reading. A regressor with
  /// measurement noise biases its coefficient (Fuller 1987, section 1.1), here the scale of rarely
  /// excited axes, over hours by many times its estimated standard deviation.
  [[nodiscard]] static Vector3 beyond_noise(const Vector3& measured, const Vector3& white,
                                            const Vector3& sigma, const T& dt) {
    constexpr double kSigmas = 3.0;
    Vector3 beyond;
    for (int i = 0; i < 3; ++i) {
      const T variance = white[i] * white[i] / dt + sigma[i] * sigma[i];
      const MaskOf<T> significant = measured[i] * measured[i] > T(kSigmas * kSigmas) * variance;
      beyond[i] = select(significant, measured[i], T(0));
    }
    return beyond;
  }

 private:
  [[nodiscard]] StrapdownJacobian<T> jacobian(const LevelRates<T>& rates, const EarthAt<T>& at,
                                              const Matrix3& c, const CorrectedImu<T>& imu,
                                              const InertialIncrement<T>& measured,
                                              const T& dt) const {
    StrapdownJacobian<T> f;
    f.half_dt = T(0.5) * dt * Vector3(at.north_scale, at.east_scale, T(1));
    f.velocity_turn = -dt * (T(2) * rates.earth + rates.transport);
    f.velocity_attitude = -c * skew(measured.velocity_mps);
    f.velocity_accel_bias = c * (-dt * imu.inverse_accel_scale).asDiagonal();
    f.scale_force = beyond_noise(measured.mean_force_mps2, accel_white_, accel_sigma_, dt);
    const Vector3 rotation =
        measured.rotation_rad - c.transpose() * Vector3(dt * (rates.earth + rates.transport));
    const Matrix3 k = skew(rotation);
    // exp(−θ) to the third order: −k³/6 = θ²/6 k.
    const T linear = T(1) - rotation.squaredNorm() / T(6);
    f.attitude_attitude = Matrix3::Identity() - linear * k + T(0.5) * k * k;
    f.attitude_gyro_bias = -dt * imu.inverse_gyro_scale;
    f.attitude_gyro_scale = f.attitude_gyro_bias.cwiseProduct(
        beyond_noise(measured.mean_rate_radps, gyro_white_, gyro_sigma_, dt));
    return f;
  }

  LocalTangentPlane plane_;
  Vector3 gyro_white_, accel_white_, gyro_sigma_, accel_sigma_;
};

/// Strapdown, the Gauss-Markov errors, the clock, and further blocks that move by themselves.
template <class T, int Offsets, class... Further>
using InsProcess =
    Process<InsState<T, Offsets, Further...>, Strapdown<T>, ins::GyroBias<T>, ins::AccelBias<T>,
            ins::GyroScale<T>, ins::AccelScale<T>, ins::Clock<T, Offsets>, Further...>;

/// A ProcessModel with ImuInterval as input.
template <class T, int Offsets = 0, class... Further>
class InsModel : public InsProcess<T, Offsets, Further...> {
 public:
  /// The plane must outlive it.
  InsModel(const LocalTangentPlane& plane, const InsNoise<T>& noise, const Further&... further)
      : InsProcess<T, Offsets, Further...>(
            Strapdown<T>(plane, noise), {error(noise, 0)}, {error(noise, 3)}, {error(noise, 6)},
            {error(noise, 9)},
            {{noise.clock_bias_walk, noise.clock_drift_walk, noise.clock_offset_walk}},
            further...) {}

 private:
  static GaussMarkov<3, T> error(const InsNoise<T>& noise, int first) {
    return {noise.sigma.template segment<3>(first), noise.tau_s.template segment<3>(first)};
  }
};

}  // namespace wayfare
