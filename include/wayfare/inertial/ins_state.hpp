#pragma once

// State of inertial navigation with GNSS: Zhang 2020, section 3.1, with a unit quaternion and a
// three-dimensional attitude error.

#include <Eigen/Core>

#include <wayfare/core/manifold.hpp>
#include <wayfare/core/so3.hpp>

namespace wayfare {

/// The 23 error states, in this order.
namespace ins_state {
inline constexpr int kPosition = 0;     ///< north, east, down, m
inline constexpr int kVelocity = 3;     ///< north, east, down, m/s
inline constexpr int kAttitude = 6;     ///< rotation vector in the unit's axes, rad (right)
inline constexpr int kGyroBias = 9;     ///< rad/s
inline constexpr int kAccelBias = 12;   ///< m/s²
inline constexpr int kGyroScale = 15;   ///< 1
inline constexpr int kAccelScale = 18;  ///< 1
inline constexpr int kClock = 21;       ///< receiver clock bias (m) and drift (m/s)
inline constexpr int kSize = 23;
}  // namespace ins_state

/// `position_m` is on a LocalTangentPlane; `q_nu` rotates the unit's axes to local level. `Offsets`
/// inter-system clock offsets (m) follow the receiver clock.
template <class T, int Offsets = 0>
struct InsState {
  using Scalar = T;
  static constexpr int kDof = ins_state::kSize + Offsets;
  static constexpr int kOffsets = Offsets;
  using Vector3 = Eigen::Matrix<T, 3, 1>;
  using Tangent = Eigen::Matrix<T, kDof, 1>;

  Vector3 position_m = Vector3::Zero();
  Vector3 velocity_mps = Vector3::Zero();
  SO3<T> q_nu;
  Vector3 gyro_bias_radps = Vector3::Zero();
  Vector3 accel_bias_mps2 = Vector3::Zero();
  Vector3 gyro_scale = Vector3::Zero();
  Vector3 accel_scale = Vector3::Zero();
  /// Bias (m) and drift (m/s) of the receiver's clock, then the offsets (m).
  Eigen::Matrix<T, 2 + Offsets, 1> clock = Eigen::Matrix<T, 2 + Offsets, 1>::Zero();

  [[nodiscard]] InsState plus(const Tangent& tau) const {
    using namespace ins_state;
    InsState y;
    y.position_m = position_m + tau.template segment<3>(kPosition);
    y.velocity_mps = velocity_mps + tau.template segment<3>(kVelocity);
    y.q_nu = q_nu.plus(tau.template segment<3>(kAttitude));
    y.gyro_bias_radps = gyro_bias_radps + tau.template segment<3>(kGyroBias);
    y.accel_bias_mps2 = accel_bias_mps2 + tau.template segment<3>(kAccelBias);
    y.gyro_scale = gyro_scale + tau.template segment<3>(kGyroScale);
    y.accel_scale = accel_scale + tau.template segment<3>(kAccelScale);
    y.clock = clock + tau.template tail<2 + Offsets>();
    return y;
  }

  [[nodiscard]] Tangent minus(const InsState& x) const {
    Tangent tau;
    tau << position_m - x.position_m, velocity_mps - x.velocity_mps, q_nu.minus(x.q_nu),
        gyro_bias_radps - x.gyro_bias_radps, accel_bias_mps2 - x.accel_bias_mps2,
        gyro_scale - x.gyro_scale, accel_scale - x.accel_scale, clock - x.clock;
    return tau;
  }

  /// The same in another scalar type; broadcast to every lane of a pack.
  template <class U>
  [[nodiscard]] InsState<U, Offsets> cast() const {
    InsState<U, Offsets> y;
    y.position_m = position_m.template cast<U>();
    y.velocity_mps = velocity_mps.template cast<U>();
    y.q_nu = q_nu.template cast<U>();
    y.gyro_bias_radps = gyro_bias_radps.template cast<U>();
    y.accel_bias_mps2 = accel_bias_mps2.template cast<U>();
    y.gyro_scale = gyro_scale.template cast<U>();
    y.accel_scale = accel_scale.template cast<U>();
    y.clock = clock.template cast<U>();
    return y;
  }
};

}  // namespace wayfare
