#pragma once

// A person walking with a phone, and its sensor readings.

#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

#include <Eigen/Core>

#include <wayfare/core/random.hpp>
#include <wayfare/core/se3.hpp>
#include <wayfare/sensors/measurements.hpp>

namespace wayfare::testing {

struct PhoneWalkOptions {
  double rate_hz = 100.0;
  double rest_s = 4.0;  ///< at the start and the end
  int steps = 80;
  double step_hz = 1.8;
  double bounce_mps2 = 3.0;  ///< amplitude of the vertical acceleration
  double sway_mps2 = 1.0;    ///< of the forward acceleration
  double turn_radps = 0.1;   ///< of the path, counter-clockwise
  double start_rad = 0.4;    ///< initial walking direction, from east
  double noise_mps2 = 0.1;
  double rate_noise_radps = 0.005;
  SO3d q_body_phone;  ///< body: x right, y forward, z up
  std::uint64_t seed = 1;
};

struct PhoneWalk {
  MargRecording samples;
  Eigen::Vector2d end = Eigen::Vector2d::Zero();  ///< with steps of one metre
  double heading_rad = 0.0;
};

inline PhoneWalk walk_phone(const PhoneWalkOptions& o) {
  Rng rng(o.seed);
  const auto noise = [&](double sigma) {
    const double x = rng.normal(), y = rng.normal();
    return Eigen::Vector3d(sigma * Eigen::Vector3d(x, y, rng.normal()));
  };
  PhoneWalk walk;
  const double walk_s = o.steps / o.step_hz, dt = 1.0 / o.rate_hz;
  const auto n = static_cast<int>((2.0 * o.rest_s + walk_s) * o.rate_hz);
  for (int i = 0; i < n; ++i) {
    const double since = (i + 1) * dt - o.rest_s;
    const bool walks = since > 0.0 && since <= walk_s;
    const double turned = std::clamp(since, 0.0, walk_s) * o.turn_radps;
    walk.heading_rad = o.start_rad + turned;
    const double phase = 2.0 * std::numbers::pi * o.step_hz * since;
    const Eigen::Vector3d moves(0.0, walks ? o.sway_mps2 * std::cos(phase) : 0.0,
                                walks ? -o.bounce_mps2 * std::cos(phase) : 0.0);
    // The body's y axis is forward, its x axis to the right.
    const SO3d q_enu_body = SO3d::exp({0.0, 0.0, walk.heading_rad - 0.5 * std::numbers::pi});
    const SO3d to_phone = o.q_body_phone.inverse();
    MargSample s;
    s.time = LogTime::from_nanoseconds(std::llround((i + 1) * dt * 1e9));
    s.angular_rate_radps = to_phone * Eigen::Vector3d(0.0, 0.0, walks ? o.turn_radps : 0.0) +
                           noise(o.rate_noise_radps);
    s.specific_force_mps2 =
        to_phone * (moves + Eigen::Vector3d(0.0, 0.0, 9.80665)) + noise(o.noise_mps2);
    s.magnetic_field_uT =
        to_phone * (q_enu_body.inverse() * Eigen::Vector3d(0.0, 18.0, -42.0)) + noise(0.3);
    walk.samples.push_back(s);
  }
  for (int k = 0; k < o.steps; ++k) {
    const double heading = o.start_rad + o.turn_radps * (k + 0.5) / o.step_hz;
    walk.end += Eigen::Vector2d(std::cos(heading), std::sin(heading));
  }
  return walk;
}

}  // namespace wayfare::testing
