#pragma once

// Error models of an inertial unit and a receiver clock. Defaults are those of an automotive MEMS
// unit such as the MPU-9250.

#include <numbers>

#include <Eigen/Core>

namespace wayfare {

/// A first-order Gauss-Markov process per axis, ṅ = −n/τ + √(2σ²/τ) w: stationary standard
/// deviation σ, correlation time τ.
struct GaussMarkov3 {
  Eigen::Vector3d sigma;
  Eigen::Vector3d tau_s;
};

/// Errors of one inertial unit: measured = (1 + scale) ∘ true + bias + white noise, per axis.
struct ImuNoise {
  /// White noise (angle and velocity random walk): rad/√s and m/s/√s.
  Eigen::Vector3d gyro_white_rad_per_sqrt_s =
      Eigen::Vector3d::Constant(0.01 * std::numbers::pi / 180.0);
  Eigen::Vector3d accel_white_mps_per_sqrt_s = Eigen::Vector3d::Constant(300e-6 * 9.80665);
  GaussMarkov3 gyro_bias_radps = {Eigen::Vector3d::Constant(0.05 * std::numbers::pi / 180.0),
                                  Eigen::Vector3d::Constant(3000.0)};
  GaussMarkov3 accel_bias_mps2 = {Eigen::Vector3d::Constant(0.03),
                                  Eigen::Vector3d::Constant(3000.0)};
  GaussMarkov3 gyro_scale = {Eigen::Vector3d::Constant(0.003), Eigen::Vector3d::Constant(20000.0)};
  GaussMarkov3 accel_scale = {Eigen::Vector3d::Constant(0.003), Eigen::Vector3d::Constant(20000.0)};
};

/// Receiver clock: random walks of bias and drift, in metres (times the speed of light).
struct ReceiverClockNoise {
  double bias_walk_m_per_sqrt_s = 0.3;
  double drift_walk_mps_per_sqrt_s = 0.1;
};

}  // namespace wayfare
