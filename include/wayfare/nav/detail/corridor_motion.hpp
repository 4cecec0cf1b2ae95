#pragma once

// Process model of corridor-aided dead reckoning: the eight states of Liu, Atia, Karamat and
// Noureldin (2015), (16) to (23), with constant and drifting bias, scale and walls.

#include <cmath>

#include <Eigen/Core>

#include <wayfare/core/se2.hpp>
#include <wayfare/filter/gauss_markov.hpp>

namespace wayfare {

/// State indices. The first eight are Liu's, with displacements and heading relative to the start
/// in the axes of the plane (x forward, y left, counter-clockwise); his bias is a zero-mean
/// first-order Gauss-Markov process, so a constant and a drift are added.
namespace corridor_state {
enum Index : int {
  kX,             ///< Δx, m
  kY,             ///< Δy, m
  kSpeed,         ///< v_f, m/s
  kSpeedX,        ///< v_x = v_f cos ΔA, m/s
  kSpeedY,        ///< v_y = v_f sin ΔA, m/s
  kHeading,       ///< ΔA, rad
  kAcceleration,  ///< a_od, error of the odometry's acceleration, m/s²
  kBiasWalk,      ///< b_z, rad/s
  kBiasConstant,  ///< rad/s
  kBiasDrift,     ///< rad/s²
  kScale,         ///< true distance per measured distance, less one
  kDirection,     ///< of the corridor in the plane, rad
  kLeft,          ///< offset of its left wall from the reference point, m
  kRight,         ///< of its right wall, m (negative)
  kEndAlpha,      ///< normal of a wall across the corridor, rad
  kEndOffset,     ///< its offset from its reference point, m
  kSize
};
}  // namespace corridor_state

using CorridorVector = Eigen::Matrix<double, corridor_state::kSize, 1>;
using CorridorMatrix = Eigen::Matrix<double, corridor_state::kSize, corridor_state::kSize>;

/// Input over the time since the previous sample.
struct CorridorInput {
  double dt_s = 0.0;
  double turn_rate_rad_s = 0.0;  ///< the gyro's mean, less the Earth rate
  double speed_m_s = 0.0;        ///< the wheels' mean
  double speed_before_m_s = 0.0;
  bool at_rest = false;           ///< the wheels stop: position and heading are constant
  double extra_turn_rad = 0.0;    ///< standard deviation of an unmeasured rotation
  double extra_distance_m = 0.0;  ///< of an unmeasured distance
};

/// Larger values weight the sensors less and the walls more.
struct CorridorNoise {
  double angle_random_walk_rad_per_sqrt_s = 6.545e-4;  ///< 2.25 °/√h
  double bias_sigma_rad_s = 3.5e-5;                    ///< Gauss-Markov part of the bias
  double bias_tau_s = 100.0;
  double acceleration_sigma_m_s2 = 1e-5;  ///< Gauss-Markov error of the wheels' acceleration
  double acceleration_tau_s = 10.0;
  double slip_m_per_sqrt_m = 0.0005;  ///< random error of the distance
};

struct CorridorStep {
  CorridorVector state;
  CorridorMatrix phi, q;
};

/// A process model for Ekf: one step of the state with its derivative and its noise.
class CorridorMotion {
 public:
  explicit CorridorMotion(const CorridorNoise& noise = {}) : noise_(noise) {}

  [[nodiscard]] CorridorStep operator()(const CorridorVector& x, const CorridorInput& u) const {
    using namespace corridor_state;
    CorridorStep step{x, CorridorMatrix::Identity(), CorridorMatrix::Zero()};
    advance_errors(x, u.dt_s, step);
    if (u.at_rest) {
      stop(step);
    } else {
      drive(x, u, step);
    }
    for (int i : {kSpeed, kSpeedX, kSpeedY}) step.q(i, i) += kTinySpeed * kTinySpeed;
    return step;
  }

 private:
  static constexpr double kTinySpeed = 1e-7;  // keeps the covariance regular at known speeds

  /// Gauss-Markov processes exactly, (22) and (23); the constant by its drift.
  void advance_errors(const CorridorVector& x, double dt, CorridorStep& step) const {
    using namespace corridor_state;
    const auto a =
        discretise_gauss_markov(noise_.acceleration_sigma_m_s2, noise_.acceleration_tau_s, dt);
    const auto b = discretise_gauss_markov(noise_.bias_sigma_rad_s, noise_.bias_tau_s, dt);
    step.phi(kAcceleration, kAcceleration) = a.phi;
    step.q(kAcceleration, kAcceleration) = a.q;
    step.phi(kBiasWalk, kBiasWalk) = b.phi;
    step.q(kBiasWalk, kBiasWalk) = b.q;
    step.phi(kBiasConstant, kBiasDrift) = dt;
    step.state[kAcceleration] = a.phi * x[kAcceleration];
    step.state[kBiasWalk] = b.phi * x[kBiasWalk];
    step.state[kBiasConstant] = x[kBiasConstant] + dt * x[kBiasDrift];
  }

  static void stop(CorridorStep& step) {
    using namespace corridor_state;
    for (int i : {kSpeed, kSpeedX, kSpeedY}) {
      step.phi.row(i).setZero();
      step.state[i] = 0.0;
    }
  }

  void drive(const CorridorVector& x, const CorridorInput& u, CorridorStep& step) const {
    using namespace corridor_state;
    const double t = u.dt_s, dw = u.speed_m_s - u.speed_before_m_s;
    // Integrals of the decaying Gauss-Markov processes over the step.
    const double a_sum = noise_.acceleration_tau_s * (1.0 - step.phi(kAcceleration, kAcceleration));
    const double b_sum = noise_.bias_tau_s * (1.0 - step.phi(kBiasWalk, kBiasWalk));
    const double turn = u.turn_rate_rad_s * t - b_sum * x[kBiasWalk] - t * x[kBiasConstant] -
                        0.5 * t * t * x[kBiasDrift];
    const double speed = x[kSpeed] + (1.0 + x[kScale]) * dw + a_sum * x[kAcceleration];
    using Row = Eigen::Matrix<double, 1, kSize>;
    Row by_turn = Row::Zero(), by_speed = Row::Zero(), heading = Row::Zero();
    by_turn[kBiasWalk] = -b_sum, by_turn[kBiasConstant] = -t, by_turn[kBiasDrift] = -0.5 * t * t;
    by_speed[kSpeed] = 1.0, by_speed[kScale] = dw, by_speed[kAcceleration] = a_sum;
    heading[kHeading] = 1.0;

    const double middle = x[kHeading] + 0.5 * turn, end = x[kHeading] + turn;
    const double cm = std::cos(middle), sm = std::sin(middle), ce = std::cos(end),
                 se = std::sin(end);
    step.state[kSpeed] = speed;
    step.state[kSpeedX] = speed * ce;
    step.state[kSpeedY] = speed * se;
    step.state[kHeading] = end;
    step.state[kX] += t * speed * cm;
    step.state[kY] += t * speed * sm;
    const Row middle_row = heading + 0.5 * by_turn, end_row = heading + by_turn;
    step.phi.row(kSpeed) = by_speed;
    step.phi.row(kSpeedX) = ce * by_speed - speed * se * end_row;  // integral of (19)
    step.phi.row(kSpeedY) = se * by_speed + speed * ce * end_row;  // of (20)
    step.phi.row(kHeading) = end_row;                              // of (21)
    step.phi.row(kX) += t * cm * by_speed - t * speed * sm * middle_row;
    step.phi.row(kY) += t * sm * by_speed + t * speed * cm * middle_row;
    step.phi(kX, kX) = step.phi(kY, kY) = 1.0;
    add_noise(u, {cm, sm}, {-t * speed * sm, t * speed * cm}, step);
  }

  /// White noise of the gyro, which acts half in the middle of the step, and slip.
  void add_noise(const CorridorInput& u, const Eigen::Vector2d& along,
                 const Eigen::Vector2d& by_heading, CorridorStep& step) const {
    using namespace corridor_state;
    const double walk = noise_.angle_random_walk_rad_per_sqrt_s;
    const double turn = walk * walk * u.dt_s + u.extra_turn_rad * u.extra_turn_rad;
    const double distance =
        noise_.slip_m_per_sqrt_m * noise_.slip_m_per_sqrt_m * std::abs(u.speed_m_s) * u.dt_s +
        u.extra_distance_m * u.extra_distance_m;
    step.q.topLeftCorner<2, 2>() +=
        distance * along * along.transpose() + turn / 3.0 * by_heading * by_heading.transpose();
    step.q(kHeading, kHeading) += turn;
    step.q.block<2, 1>(kX, kHeading) += 0.5 * turn * by_heading;
    step.q.block<1, 2>(kHeading, kX) += 0.5 * turn * by_heading.transpose();
  }

  CorridorNoise noise_;
};

}  // namespace wayfare
