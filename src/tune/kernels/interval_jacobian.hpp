#pragma once

#include <array>
#include <tuple>

#include <Eigen/Core>

namespace wayfare::fitness_kernels {

/// Errors after an interval from those at its beginning, as those of a Coupling.
template <class T>
struct IntervalJacobian {
  using Vector3 = Eigen::Matrix<T, 3, 1>;
  using Matrix3 = Eigen::Matrix<T, 3, 3>;

  Matrix3 position_velocity, position_attitude, velocity_velocity, velocity_attitude,
      attitude_attitude;
  /// By the errors of InsNoise in its order; attitude: by the two of the gyro.
  std::array<Matrix3, 4> position_sensor, velocity_sensor;
  std::array<Matrix3, 2> attitude_sensor;

  [[nodiscard]] std::tuple<Vector3, Vector3, Vector3> operator()(
      const Vector3& position, const Vector3& velocity, const Vector3& attitude,
      const Vector3& gyro_bias, const Vector3& accel_bias, const Vector3& gyro_scale,
      const Vector3& accel_scale) const {
    const auto of_sensors = [&](const std::array<Matrix3, 4>& m, int i) {
      return (row(m[0], i, gyro_bias) + row(m[1], i, accel_bias)) +
             (row(m[2], i, gyro_scale) + row(m[3], i, accel_scale));
    };
    Vector3 p, v, a;
    for (int i = 0; i < 3; ++i) {
      p[i] = position[i] + row(position_velocity, i, velocity) +
             row(position_attitude, i, attitude) + of_sensors(position_sensor, i);
      v[i] = row(velocity_velocity, i, velocity) + row(velocity_attitude, i, attitude) +
             of_sensors(velocity_sensor, i);
      a[i] = row(attitude_attitude, i, attitude) + row(attitude_sensor[0], i, gyro_bias) +
             row(attitude_sensor[1], i, gyro_scale);
    }
    return {p, v, a};
  }

 private:
  static T row(const Matrix3& m, int i, const Vector3& v) {
    return m(i, 0) * v[0] + m(i, 1) * v[1] + m(i, 2) * v[2];
  }
};

}  // namespace wayfare::fitness_kernels
