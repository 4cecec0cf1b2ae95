#pragma once

// State and process of corridor-aided dead reckoning: the eight states of Liu, Atia, Karamat and
// Noureldin (2015), (16) to (23), with constant and drifting bias, scale and walls.

#include <cmath>
#include <tuple>

#include <Eigen/Core>

#include <wayfare/core/se2.hpp>
#include <wayfare/filter/process.hpp>

namespace wayfare {

/// Input over the time since the previous sample.
struct CorridorInput {
  double dt_s = 0.0;              ///< since the previous sample
  double turn_rate_rad_s = 0.0;   ///< the gyro's mean, less the Earth rate
  double speed_m_s = 0.0;         ///< the wheels' mean
  double speed_before_m_s = 0.0;  ///< at its beginning
  bool at_rest = false;           ///< the wheels stop: position and heading are constant
  double extra_turn_rad = 0.0;    ///< standard deviation of an unmeasured rotation
  double extra_distance_m = 0.0;  ///< of an unmeasured distance
};

/// Larger values weight the sensors less and the walls more.
struct CorridorNoise {
  double angle_random_walk_rad_per_sqrt_s = 6.545e-4;  ///< 2.25 °/√h
  double bias_sigma_rad_s = 3.5e-5;                    ///< Gauss-Markov part of the bias
  double bias_tau_s = 100.0;                           ///< its correlation time
  double acceleration_sigma_m_s2 = 1e-5;  ///< Gauss-Markov error of the wheels' acceleration
  double acceleration_tau_s = 10.0;       ///< its correlation time
  double slip_m_per_sqrt_m = 0.0005;      ///< random error of the distance
};

/// The blocks of CorridorState. Liu's displacements and heading are relative to the start, in the
/// axes of the plane (x forward, y left, counter-clockwise); his bias is a zero-mean first-order
/// Gauss-Markov process, so a constant and a drift are added.
namespace corridor {

using Number = Eigen::Matrix<double, 1, 1>;  ///< of one component

/// Δx, Δy, m.
struct Position {
  using Value = Eigen::Vector2d;                                      ///< m
  static constexpr BlockNames<2> kNames{"position x", "position y"};  ///< of its errors
};
/// Speed v_f, forward, m/s.
struct Speed {
  using Value = Number;                            ///< m/s
  static constexpr BlockNames<1> kNames{"speed"};  ///< of its error
};
/// v_x = v_f cos ΔA, v_y = v_f sin ΔA, m/s.
struct Velocity {
  using Value = Eigen::Vector2d;                                      ///< m/s
  static constexpr BlockNames<2> kNames{"velocity x", "velocity y"};  ///< of its errors
};
/// ΔA, rad, not wrapped.
struct Heading {
  using Value = Number;                              ///< rad
  static constexpr BlockNames<1> kNames{"heading"};  ///< of its error
};
/// Error a_od of the odometry's acceleration, m/s².
struct Acceleration : GaussMarkov<1> {
  static constexpr BlockNames<1> kNames{"acceleration error"};  ///< of its error
};
/// The correlated part b_z of the gyro's bias, rad/s.
struct BiasWalk : GaussMarkov<1> {
  static constexpr BlockNames<1> kNames{"gyro bias walk"};  ///< of its error
};
/// The constant part of the gyro's bias, rad/s, and its drift, rad/s².
struct Bias {
  using Value = Eigen::Vector2d;                                          ///< bias, drift
  static constexpr BlockNames<2> kNames{"gyro bias", "gyro bias drift"};  ///< of its errors

  /// Transition over an interval.
  struct Phi {
    double dt_s;  ///< s
    /// Error after the interval.
    [[nodiscard]] Value operator()(const Value& d) const { return {d[0] + dt_s * d[1], d[1]}; }
  };
  /// Without noise.
  [[nodiscard]] BlockStep<Phi, NoNoise> discretise(double dt_s) const { return {{dt_s}, {}}; }
};
/// True distance per measured distance, less one.
struct Scale : RandomConstant<1> {
  static constexpr BlockNames<1> kNames{"speed scale"};  ///< of its error
};
/// Direction of the corridor in the plane, rad; offsets of its left and right wall (negative) from
/// the reference point, m, along its left-hand normal.
struct Sides : RandomConstant<3> {
  /// Of its errors.
  static constexpr BlockNames<3> kNames{"corridor direction", "left wall", "right wall"};
};
/// Direction of the normal of a wall across the corridor, rad; its offset from its reference
/// point, m.
struct End : RandomConstant<2> {
  static constexpr BlockNames<2> kNames{"end wall normal", "end wall offset"};  ///< of its errors
};

/// Moves the vehicle by gyro and wheels, (16) to (21).
struct DeadReckoning {
  using Moves = BlockList<Position, Speed, Velocity, Heading>;  ///< blocks moved
  /// Blocks they depend on.
  using By = BlockList<Position, Speed, Velocity, Heading, Acceleration, BiasWalk, Bias, Scale>;
  CorridorNoise noise;  ///< of gyro and wheels

  /// Errors after a step from those before. At rest only position and heading remain.
  struct Jacobian {
    bool at_rest;            ///< only position and heading remain
    double t,                ///< dt, s
        speed_change,        ///< change of the speed, m/s
        acceleration_sum,    ///< of Acceleration
        walk_sum,            ///< of BiasWalk
        speed;               ///< m/s, mean
    Eigen::Vector2d middle,  ///< half way through the turn
        end;                 ///< at its end

    /// Errors of the blocks moved.
    [[nodiscard]] std::tuple<Eigen::Vector2d, Number, Eigen::Vector2d, Number> operator()(
        const Eigen::Vector2d& position, const Number& v, const Eigen::Vector2d&,
        const Number& heading, const Number& acceleration, const Number& walk,
        const Eigen::Vector2d& bias, const Number& scale) const {
      if (at_rest) return {position, Number(0.0), Eigen::Vector2d(0.0, 0.0), heading};
      const double turn = -walk_sum * walk[0] - t * bias[0] - 0.5 * t * t * bias[1];
      const double dv = v[0] + speed_change * scale[0] + acceleration_sum * acceleration[0];
      const double half = heading[0] + 0.5 * turn, full = heading[0] + turn;
      return {{position[0] + t * (middle[0] * dv - speed * middle[1] * half),
               position[1] + t * (middle[1] * dv + speed * middle[0] * half)},
              Number(dv),
              {end[0] * dv - speed * end[1] * full, end[1] * dv + speed * end[0] * full},
              Number(full)};
    }
  };
  using Noise = Eigen::Matrix<double, 6, 6>;  ///< of (position, speed, velocity, heading)

  /// Moved blocks, their Jacobian and noise, as Process takes them.
  [[nodiscard]] auto step(const Eigen::Vector2d& position, const Number& v, const Eigen::Vector2d&,
                          const Number& heading, const Number& acceleration, const Number& walk,
                          const Eigen::Vector2d& bias, const Number& scale,
                          const CorridorInput& u) const {
    const double t = u.dt_s, change = u.speed_m_s - u.speed_before_m_s;
    // Integrals of the decaying Gauss-Markov processes over the step.
    const double acceleration_sum = integral(noise.acceleration_tau_s, t);
    const double walk_sum = integral(noise.bias_tau_s, t);
    const double turn =
        u.turn_rate_rad_s * t - walk_sum * walk[0] - t * bias[0] - 0.5 * t * t * bias[1];
    const double speed =
        u.at_rest ? 0.0 : v[0] + (1.0 + scale[0]) * change + acceleration_sum * acceleration[0];
    const double after = u.at_rest ? heading[0] : heading[0] + turn;
    const Eigen::Vector2d middle = unit(heading[0] + 0.5 * turn), end = unit(after);
    return CoupledStep{
        std::tuple{Eigen::Vector2d(position + t * speed * middle), Number(speed),
                   Eigen::Vector2d(speed * end), Number(after)},
        Jacobian{u.at_rest, t, change, acceleration_sum, walk_sum, speed, middle, end},
        noise_of(u, middle, t * speed)};
  }

 private:
  static Eigen::Vector2d unit(double angle_rad) {
    return {std::cos(angle_rad), std::sin(angle_rad)};
  }
  static double integral(double tau_s, double dt_s) {
    return tau_s * (1.0 - discretise_gauss_markov(0.0, tau_s, dt_s).phi);
  }

  /// White noise of the gyro, which acts half in the middle of the step, and slip.
  [[nodiscard]] Noise noise_of(const CorridorInput& u, const Eigen::Vector2d& along,
                               double distance_m) const {
    constexpr double kTinySpeed = 1e-7;  // keeps the covariance regular at known speeds
    Noise q = Noise::Zero();
    q.diagonal().segment<3>(2).setConstant(kTinySpeed * kTinySpeed);
    if (u.at_rest) return q;
    const double gyro = noise.angle_random_walk_rad_per_sqrt_s, slip = noise.slip_m_per_sqrt_m;
    const double turn = gyro * gyro * u.dt_s + u.extra_turn_rad * u.extra_turn_rad;
    const double distance =
        slip * slip * std::abs(u.speed_m_s) * u.dt_s + u.extra_distance_m * u.extra_distance_m;
    const Eigen::Vector2d by_heading(-distance_m * along[1], distance_m * along[0]);
    for (int i = 0; i < 2; ++i) {
      for (int j = 0; j < 2; ++j)
        q(i, j) = distance * along[i] * along[j] + turn / 3.0 * by_heading[i] * by_heading[j];
      q(i, 5) = q(5, i) = 0.5 * turn * by_heading[i];
    }
    q(5, 5) = turn;
    return q;
  }
};

}  // namespace corridor

/// Ten blocks, in this order.
using CorridorState = State<corridor::Position, corridor::Speed, corridor::Velocity,
                            corridor::Heading, corridor::Acceleration, corridor::BiasWalk,
                            corridor::Bias, corridor::Scale, corridor::Sides, corridor::End>;

/// The process of CorridorState with CorridorInput as input.
struct CorridorMotion
    : Process<CorridorState, corridor::DeadReckoning, corridor::Acceleration, corridor::BiasWalk,
              corridor::Bias, corridor::Scale, corridor::Sides, corridor::End> {
  /// With the noise of gyro and wheels.
  explicit CorridorMotion(const CorridorNoise& noise = {})
      : Process({noise}, {{noise.acceleration_sigma_m_s2, noise.acceleration_tau_s}},
                {{noise.bias_sigma_rad_s, noise.bias_tau_s}}, {}, {}, {}, {}) {}
};

}  // namespace wayfare
