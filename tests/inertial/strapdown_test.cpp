#include <wayfare/inertial/ins_state.hpp>

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

namespace wayfare {
namespace {

using Eigen::Vector3d;

/// Integrates a signal of rates and forces by integrate() and strapdown_step().
template <class Signal>
Navigation<double> run(const LocalTangentPlane& plane, Navigation<double> x, const Signal& signal,
                       double dt, int steps) {
  for (int i = 0; i < steps; ++i) {
    const auto a = signal(i * dt), b = signal((i + 1) * dt);
    x = strapdown_step(x, plane.earth(x.position_m),
                       integrate<double>(a.first, b.first, a.second, b.second, dt), dt);
  }
  return x;
}

// At rest a unit measures the Earth rate and gravity; after an hour it must not have moved. (The
// vertical channel is unstable, but not visibly within an hour's rounding.)
TEST(Strapdown, StaysAtRestOnTheRotatingEarth) {
  const LocalTangentPlane plane({Angle::degrees(52.0), Angle::degrees(13.0), 40.0});
  const EarthAt<double> at = plane.earth<double>(Vector3d::Zero());
  const SO3d q = SO3d::exp(Vector3d(0.1, -0.2, 2.0));
  const Vector3d earth = level_rates<double>(at, Vector3d::Zero()).earth;
  const Vector3d rate = q.inverse() * earth;
  const Vector3d force = q.inverse() * Vector3d(0.0, 0.0, -at.gravity_mps2);
  const auto end = run(
      plane, {Vector3d::Zero(), Vector3d::Zero(), q},
      [&](double) { return std::pair(rate, force); }, 0.1, 36000);
  EXPECT_LT(end.position_m.norm(), 0.02);  // third order of a step of 0.1 s: g (ΩT)², 5e-10 m/s²
  EXPECT_LT(end.velocity_mps.norm(), 1e-5);
  EXPECT_LT(end.q_nu.minus(q).norm(), 1e-9);
}

// Classical coning: the axis describes a cone of half angle β at frequency Ω, and plain integration
// of the rates drifts by β²Ω/2 rad/s (Savage 1998, part 1).
TEST(Strapdown, FollowsConing) {
  const double beta = 0.02, omega = 2.0 * std::numbers::pi * 5.0, dt = 0.01;
  // Attitude: rotation vector β (cos Ωt, sin Ωt, 0); its body rate in closed form.
  const auto attitude = [&](double t) {
    return SO3d::exp(beta * Vector3d(std::cos(omega * t), std::sin(omega * t), 0.0));
  };
  const auto rate = [&](double t) {
    const double s = omega * std::sin(beta);
    return Vector3d(-s * std::sin(omega * t), s * std::cos(omega * t),
                    -omega * (1.0 - std::cos(beta)));
  };
  SO3d plain = attitude(0.0), full = plain;
  const int steps = 2000;
  for (int i = 0; i < steps; ++i) {
    const Vector3d a = rate(i * dt), b = rate((i + 1) * dt);
    full = full * SO3d::exp(integrate<double>(a, b, a, b, dt).rotation_rad);
    plain = plain * SO3d::exp(0.5 * dt * (a + b));
  }
  const double drift = 0.5 * beta * beta * omega * steps * dt;  // 0.13 rad
  // Both lose (Ω dt)²/12 of the cone's angle by the trapezoidal rule.
  EXPECT_LT(full.minus(attitude(steps * dt)).norm(), 0.15 * drift);
  EXPECT_LT(full.minus(attitude(steps * dt)).norm(),
            0.8 * plain.minus(attitude(steps * dt)).norm());
}

// Second order: half the step, a quarter of the error.
TEST(Strapdown, ConvergesToSecondOrder) {
  const LocalTangentPlane plane({Angle::degrees(40.0), Angle::degrees(-105.0), 1600.0});
  const auto signal = [](double t) {
    return std::pair(Vector3d(0.4 * std::sin(3.0 * t), 0.3 * std::cos(2.0 * t), 0.5),
                     Vector3d(1.0 + std::sin(2.0 * t), std::cos(3.0 * t), -9.8));
  };
  const Navigation<double> start{Vector3d::Zero(), Vector3d(10.0, 0.0, 0.0), SO3d()};
  const auto fine = run(plane, start, signal, 1.0 / 4096, 4096 * 4);
  const auto error = [&](int rate) {
    const auto x = run(plane, start, signal, 1.0 / rate, rate * 4);
    return Vector3d((x.position_m - fine.position_m).norm(),
                    (x.velocity_mps - fine.velocity_mps).norm(), x.q_nu.minus(fine.q_nu).norm());
  };
  const Vector3d coarse = error(32), half = error(64);
  for (int i = 0; i < 3; ++i) EXPECT_GT(coarse[i] / half[i], 3.5) << i;
  EXPECT_LT(half[0], 0.02);
}

}  // namespace
}  // namespace wayfare
