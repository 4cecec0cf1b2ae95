#pragma once

// Motion of a sensor on a head, in a hand or on a rig: inertial navigation in six degrees of
// freedom over a flat, non-rotating floor, for rooms and minutes. (Over the Earth: ins_model.hpp.)

#include <algorithm>
#include <cmath>

#include <Eigen/Core>

#include <wayfare/core/manifold.hpp>
#include <wayfare/core/se2.hpp>
#include <wayfare/core/so3.hpp>
#include <wayfare/filter/gauss_markov.hpp>
#include <wayfare/inertial/strapdown.hpp>

namespace wayfare {

/// Fifteen error states, in this order: position, velocity, attitude (rotation vector in the body's
/// axes, right), gyro bias, accelerometer bias. Map axes have z up; the body's x points forward, z
/// up.
struct CarrierState {
  using Scalar = double;
  static constexpr int kDof = 15;
  static constexpr int kPosition = 0, kVelocity = 3, kAttitude = 6, kGyroBias = 9, kAccelBias = 12;
  using Tangent = Eigen::Matrix<double, kDof, 1>;

  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d velocity_mps = Eigen::Vector3d::Zero();
  SO3d q_map_body;
  Eigen::Vector3d gyro_bias_radps = Eigen::Vector3d::Zero();
  Eigen::Vector3d accel_bias_mps2 = Eigen::Vector3d::Zero();

  [[nodiscard]] CarrierState plus(const Tangent& tau) const {
    return {position_m + tau.segment<3>(kPosition), velocity_mps + tau.segment<3>(kVelocity),
            q_map_body.plus(tau.segment<3>(kAttitude)), gyro_bias_radps + tau.segment<3>(kGyroBias),
            accel_bias_mps2 + tau.segment<3>(kAccelBias)};
  }
  [[nodiscard]] Tangent minus(const CarrierState& x) const {
    Tangent tau;
    tau << position_m - x.position_m, velocity_mps - x.velocity_mps, q_map_body.minus(x.q_map_body),
        gyro_bias_radps - x.gyro_bias_radps, accel_bias_mps2 - x.accel_bias_mps2;
    return tau;
  }

  /// Seen from above: x, y and the heading of the body's x axis.
  [[nodiscard]] SE2d planar() const;
  /// ∂(x, y, heading)/∂τ, x and y along the map's axes.
  [[nodiscard]] Eigen::Matrix<double, 3, kDof> planar_jacobian() const;
};

/// White noise of the samples, rad/√s and m/s/√s, and biases as Gauss-Markov processes. The noise
/// also covers scale and alignment errors and shocks.
struct CarrierNoise {
  double gyro_white = 0.001;
  double accel_white = 0.03;
  double gyro_bias_radps = 0.01, gyro_bias_time_s = 1000.0;
  double accel_bias_mps2 = 0.05, accel_bias_time_s = 1000.0;
};

/// The process model (see ProcessModel): q⁺ = q exp(Δθ), v⁺ = v + q Δv − g Δt, p⁺ = p + Δt (v +
/// v⁺)/2 with Δθ, Δv of the samples less the biases.
class CarrierModel {
 public:
  static constexpr double kGravity_mps2 = 9.80665;
  using Square = Eigen::Matrix<double, CarrierState::kDof, CarrierState::kDof>;

  struct Step {
    CarrierState state;
    Square phi, q;
  };

  explicit CarrierModel(const CarrierNoise& noise = {}) : noise_(noise) {}

  /// Samples in the body's axes.
  [[nodiscard]] Step operator()(const CarrierState& x, const ImuInterval& u) const;

 private:
  CarrierNoise noise_;
};

inline SE2d CarrierState::planar() const {
  const Eigen::Vector3d x = q_map_body.matrix().col(0);
  return SE2d(position_m.x(), position_m.y(), Angle::radians(std::atan2(x.y(), x.x())));
}

/// The axis a = q e₁ moves by −q [e₁]× δθ, and the heading of a by (a₁ da₂ − a₂ da₁)/(a₁² + a₂²).
inline Eigen::Matrix<double, 3, CarrierState::kDof> CarrierState::planar_jacobian() const {
  constexpr double kUpright = 1e-6;  // no heading when x is vertical
  const Eigen::Matrix3d r = q_map_body.matrix();
  const Eigen::Matrix3d moved = -r * skew(Eigen::Vector3d(Eigen::Vector3d::UnitX()));
  const double level2 = std::max(kUpright, r(0, 0) * r(0, 0) + r(1, 0) * r(1, 0));
  Eigen::Matrix<double, 3, kDof> c = Eigen::Matrix<double, 3, kDof>::Zero();
  c(0, kPosition) = c(1, kPosition + 1) = 1;
  c.block<1, 3>(2, kAttitude) = (r(0, 0) * moved.row(1) - r(1, 0) * moved.row(0)) / level2;
  return c;
}

inline CarrierModel::Step CarrierModel::operator()(const CarrierState& x,
                                                   const ImuInterval& u) const {
  using S = CarrierState;
  const double dt = u.dt_s;
  const InertialIncrement<double> measured = integrate<double>(
      u.begin_rate_radps - x.gyro_bias_radps, u.end_rate_radps - x.gyro_bias_radps,
      u.begin_force_mps2 - x.accel_bias_mps2, u.end_force_mps2 - x.accel_bias_mps2, dt);
  const Eigen::Matrix3d r = x.q_map_body.matrix();
  Step step{x, Square::Identity(), Square::Zero()};
  step.state.q_map_body = x.q_map_body.plus(measured.rotation_rad);
  step.state.velocity_mps +=
      r * measured.velocity_mps - dt * kGravity_mps2 * Eigen::Vector3d::UnitZ();
  step.state.position_m += 0.5 * dt * (x.velocity_mps + step.state.velocity_mps);

  const auto bias = [&](double sigma, double tau_s, int at, S& state_of) {
    const ProcessStep1<double> kept = discretise_gauss_markov(sigma, tau_s, dt);
    step.phi.block<3, 3>(at, at) *= kept.phi;
    step.q.diagonal().segment<3>(at).setConstant(kept.q);
    (at == S::kGyroBias ? state_of.gyro_bias_radps : state_of.accel_bias_mps2) *= kept.phi;
  };
  bias(noise_.gyro_bias_radps, noise_.gyro_bias_time_s, S::kGyroBias, step.state);
  bias(noise_.accel_bias_mps2, noise_.accel_bias_time_s, S::kAccelBias, step.state);

  const Eigen::Matrix3d halfway = r * SO3d::exp(0.5 * measured.rotation_rad).matrix();
  const Eigen::Matrix3d by_attitude = -r * skew(measured.velocity_mps);
  step.phi.block<3, 3>(S::kVelocity, S::kAttitude) = by_attitude;
  step.phi.block<3, 3>(S::kVelocity, S::kGyroBias) = -0.5 * dt * by_attitude;
  step.phi.block<3, 3>(S::kVelocity, S::kAccelBias) = -dt * halfway;
  step.phi.block<3, 3>(S::kPosition, S::kVelocity).diagonal().setConstant(dt);
  step.phi.block<3, 3>(S::kPosition, S::kAttitude) = 0.5 * dt * by_attitude;
  step.phi.block<3, 3>(S::kPosition, S::kAccelBias) = -0.5 * dt * dt * halfway;
  step.phi.block<3, 3>(S::kAttitude, S::kAttitude) = SO3d::exp(-measured.rotation_rad).matrix();
  step.phi.block<3, 3>(S::kAttitude, S::kGyroBias) =
      -dt * SO3d::right_jacobian(measured.rotation_rad);
  const double accel = noise_.accel_white * noise_.accel_white * dt;
  step.q.diagonal().segment<3>(S::kVelocity).setConstant(accel);
  step.q.diagonal().segment<3>(S::kPosition).setConstant(accel * dt * dt / 4);
  step.q.diagonal()
      .segment<3>(S::kAttitude)
      .setConstant(noise_.gyro_white * noise_.gyro_white * dt);
  return step;
}

}  // namespace wayfare
