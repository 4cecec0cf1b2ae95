#pragma once

// A simulated moving body and its sensor readings.

#include <cmath>
#include <numbers>
#include <vector>

#include <Eigen/Core>

#include <wayfare/core/random.hpp>
#include <wayfare/core/se3.hpp>
#include <wayfare/sensors/measurements.hpp>

namespace wayfare::testing {

inline constexpr double kGravity = 9.80665;
inline constexpr double kDegree = std::numbers::pi / 180.0;

struct MotionOptions {
  double rate_hz = 100.0;
  double duration_s = 60.0;
  double rest_s = 0.0;          ///< at the start
  double turn_radps = 1.0;      ///< amplitude of the rate about each axis
  double velocity_sigma = 0.0;  ///< Gauss-Markov, m/s
  double velocity_time_s = 0.1;
  Eigen::Vector3d bias_radps = Eigen::Vector3d::Zero();
  double rate_density = 0.0;   ///< rad/s/√Hz
  double force_density = 0.0;  ///< m/s²/√Hz
  Eigen::Vector3d field_enu_uT{0.0, 18.0, -42.0};
  double field_noise_uT = 0.0;
  double heading_density = 0.0;       ///< of the field's direction, rad·√s
  double magnetometer_delay_s = 0.0;  ///< a multiple of the period
  SO3d q_body_sensor;                 ///< mounting of the sensor
  SO3d start = SO3d::exp({0.1, -0.2, 0.7});
  std::uint64_t seed = 1;
};

struct Motion {
  MargRecording samples;
  std::vector<SO3d> q_enu_body;  ///< of the sensor's axes, at the samples
};

inline Eigen::Vector3d normal3(Rng& rng, double sigma) {
  const double x = rng.normal(), y = rng.normal();
  return sigma * Eigen::Vector3d(x, y, rng.normal());
}

/// Rates are constant within a period, so that integrating them is exact.
inline Motion simulate(const MotionOptions& o) {
  Rng rng(o.seed);
  Motion motion;
  const double dt = 1.0 / o.rate_hz;
  const auto n = static_cast<std::size_t>(o.duration_s * o.rate_hz);
  const auto delay = static_cast<std::size_t>(std::lround(o.magnetometer_delay_s * o.rate_hz));
  const double phi = std::exp(-dt / o.velocity_time_s);
  SO3d q = o.start;
  Eigen::Vector3d velocity = normal3(rng, o.velocity_sigma);
  std::vector<SO3d> attitudes;
  for (std::size_t i = 0; i < n; ++i) {
    const double t = static_cast<double>(i) * dt;
    Eigen::Vector3d rate = Eigen::Vector3d::Zero(), next = velocity;
    if (t >= o.rest_s) {
      rate = o.turn_radps *
             Eigen::Vector3d(std::sin(0.9 * t), std::cos(1.3 * t + 0.4), std::sin(0.7 * t + 1.0));
      next = phi * velocity + normal3(rng, o.velocity_sigma * std::sqrt(1.0 - phi * phi));
    } else {
      next.setZero();
      velocity.setZero();
    }
    const SO3d middle = q * SO3d::exp(rate * (0.5 * dt));
    q = q * SO3d::exp(rate * dt);
    attitudes.push_back(q);
    const Eigen::Vector3d up(0.0, 0.0, kGravity);
    MargSample s;
    s.time = LogTime::from_nanoseconds(1'000'000'000 + std::llround(t * 1e9));
    s.angular_rate_radps = rate + o.bias_radps + normal3(rng, o.rate_density / std::sqrt(dt));
    s.specific_force_mps2 = middle.inverse() * (up + (next - velocity) / dt) +
                            normal3(rng, o.force_density / std::sqrt(dt));
    const SO3d& seen = attitudes[i >= delay ? i - delay : 0];
    const SO3d twist = SO3d::exp({0.0, 0.0, o.heading_density / std::sqrt(dt) * rng.normal()});
    s.magnetic_field_uT =
        seen.inverse() * (twist * o.field_enu_uT) + normal3(rng, o.field_noise_uT);
    const SO3d to_sensor = o.q_body_sensor.inverse();
    for (auto* v : {&s.angular_rate_radps, &s.specific_force_mps2, &s.magnetic_field_uT})
      *v = to_sensor * *v;
    motion.samples.push_back(s);
    motion.q_enu_body.push_back(q * o.q_body_sensor);
    velocity = next;
  }
  return motion;
}

}  // namespace wayfare::testing
