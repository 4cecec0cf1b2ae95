#pragma once

// A foot on a known path and the readings of an inertial unit on it.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include <wayfare/core/random.hpp>
#include <wayfare/core/se3.hpp>
#include <wayfare/sensors/measurements.hpp>

namespace wayfare::testing {

struct FootWalkOptions {
  double rate_hz = 200.0;
  int strides = 40;
  double rest_s = 2.0;  ///< at the start and the end
  double swing_s = 0.45, stance_s = 0.4;
  double stride_m = 1.3, lift_m = 0.12, climb_m = 0.0;  ///< per stride
  double turn_rad = 0.15;                               ///< per stride
  double pitch_rad = 0.6;
  Eigen::Vector3d rate_bias{0.001, -0.0015, 0.001};
  Eigen::Vector3d force_bias{0.03, -0.02, 0.04};
  double rate_density = 0.0001, force_density = 0.002;
  double rate_range = 1e9;  ///< readings are clipped here
  SO3d q_foot_sensor;
  std::uint64_t seed = 1;
};

struct FootWalk {
  std::vector<ImuSample> samples;
  std::vector<Eigen::Vector3d> position;  ///< after the samples, from the start; z up
  double length_m = 0.0;
};

/// Each swing is a smooth step of time (10u³ − 15u⁴ + 6u⁵) along a straight line, with a hump
/// (64u³(1 − u)³) for lift and pitch.
inline FootWalk walk_foot(const FootWalkOptions& o) {
  struct Pose {
    Eigen::Vector3d p, v;
    SO3d q;
  };
  const double stride_s = o.swing_s + o.stance_s;
  const auto corner = [&](int n) {
    Eigen::Vector3d p = Eigen::Vector3d::Zero();
    for (int i = 0; i < n; ++i)
      p += Eigen::Vector3d(o.stride_m * std::cos(i * o.turn_rad),
                           o.stride_m * std::sin(i * o.turn_rad), o.climb_m);
    return p;
  };
  std::vector<Eigen::Vector3d> corners;
  for (int i = 0; i <= o.strides; ++i) corners.push_back(corner(i));
  const auto at = [&](double t) {
    const double since = std::max(0.0, t - o.rest_s);
    const int n = std::min(o.strides, static_cast<int>(since / stride_s));
    const double u = n == o.strides ? 0.0 : std::min(1.0, (since - n * stride_s) / o.swing_s);
    const double step = u * u * u * (10.0 + u * (-15.0 + 6.0 * u));
    const double step_rate = 30.0 * u * u * (1.0 - u) * (1.0 - u) / o.swing_s;
    const double hump = 64.0 * std::pow(u * (1.0 - u), 3);
    const double hump_rate = 192.0 * std::pow(u * (1.0 - u), 2) * (1.0 - 2.0 * u) / o.swing_s;
    const auto next = static_cast<std::size_t>(std::min(n + 1, o.strides));
    const Eigen::Vector3d along = corners[next] - corners[static_cast<std::size_t>(n)];
    const Eigen::Vector3d up(0.0, 0.0, o.lift_m);
    return Pose{
        corners[static_cast<std::size_t>(n)] + step * along + hump * up,
        step_rate * along + hump_rate * up,
        SO3d::exp({0.0, 0.0, (n + step) * o.turn_rad}) * SO3d::exp({0.0, o.pitch_rad * hump, 0.0})};
  };
  Rng rng(o.seed);
  const auto noise = [&](double sigma) {
    const double x = rng.normal(), y = rng.normal();
    return Eigen::Vector3d(sigma * Eigen::Vector3d(x, y, rng.normal()));
  };
  FootWalk walk;
  const double dt = 1.0 / o.rate_hz;
  const auto count = static_cast<int>((2.0 * o.rest_s + o.strides * stride_s) * o.rate_hz);
  const SO3d to_sensor = o.q_foot_sensor.inverse();
  for (int i = 0; i < count; ++i) {
    const Pose before = at(i * dt), after = at((i + 1) * dt);
    const Eigen::Vector3d turn = (before.q.inverse() * after.q).log();
    const SO3d middle = before.q * SO3d::exp(0.5 * turn);
    const Eigen::Vector3d acceleration = (after.v - before.v) / dt;
    const Eigen::Vector3d force =
        middle.inverse() * (acceleration + Eigen::Vector3d(0.0, 0.0, 9.80665));
    ImuSample s;
    s.time = LogTime::from_nanoseconds(std::llround((i + 1) * dt * 1e9));
    s.angular_rate_radps =
        to_sensor * (turn / dt) + o.rate_bias + noise(o.rate_density / std::sqrt(dt));
    s.angular_rate_radps =
        s.angular_rate_radps.cwiseMax(-o.rate_range).cwiseMin(o.rate_range).eval();
    s.specific_force_mps2 =
        to_sensor * force + o.force_bias + noise(o.force_density / std::sqrt(dt));
    walk.samples.push_back(s);
    walk.position.push_back(after.p);
  }
  walk.length_m = o.strides * o.stride_m;
  return walk;
}

}  // namespace wayfare::testing
