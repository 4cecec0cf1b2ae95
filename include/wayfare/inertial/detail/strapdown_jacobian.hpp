#pragma once

#include <tuple>

#include <Eigen/Core>

namespace wayfare {

/// The errors of position, velocity and attitude after a strapdown step, from those before (Groves
/// 2013, section 14.2.4; Zhang 2020, section 3.1), element by element so that compilers vectorise
/// it.
template <class T>
struct StrapdownJacobian {
  using Vector3 = Eigen::Matrix<T, 3, 1>;
  using Matrix3 = Eigen::Matrix<T, 3, 3>;

  Vector3 half_dt;        ///< position on the plane per sum of both velocities
  Vector3 velocity_turn;  ///< velocity's block of itself is I + [velocity_turn]×
  Matrix3 velocity_attitude, velocity_accel_bias;
  /// Columns of velocity_accel_bias times this are those of the accelerometer scale.
  Vector3 scale_force;
  Matrix3 attitude_attitude;
  Vector3 attitude_gyro_bias, attitude_gyro_scale;  ///< diagonals

  [[nodiscard]] std::tuple<Vector3, Vector3, Vector3> operator()(
      const Vector3& position, const Vector3& velocity, const Vector3& attitude,
      const Vector3& gyro_bias, const Vector3& accel_bias, const Vector3& gyro_scale,
      const Vector3& accel_scale) const {
    Vector3 accel, new_position, new_velocity, new_attitude;
    for (int i = 0; i < 3; ++i) accel[i] = accel_bias[i] + scale_force[i] * accel_scale[i];
    for (int i = 0; i < 3; ++i) {
      const int j = (i + 1) % 3, k = (i + 2) % 3;
      new_velocity[i] = velocity[i] +
                        (velocity_turn[j] * velocity[k] - velocity_turn[k] * velocity[j]) +
                        row(velocity_attitude, i, attitude) + row(velocity_accel_bias, i, accel);
      new_position[i] = position[i] + half_dt[i] * (velocity[i] + new_velocity[i]);
      new_attitude[i] =
          row(attitude_attitude, i, attitude) +
          (attitude_gyro_bias[i] * gyro_bias[i] + attitude_gyro_scale[i] * gyro_scale[i]);
    }
    return {new_position, new_velocity, new_attitude};
  }

 private:
  static T row(const Matrix3& m, int i, const Vector3& v) {
    return m(i, 0) * v[0] + m(i, 1) * v[1] + m(i, 2) * v[2];
  }
};

}  // namespace wayfare
