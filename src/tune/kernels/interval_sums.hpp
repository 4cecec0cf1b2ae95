#pragma once

#include <array>
#include <cstddef>

#include <Eigen/Core>

#include <wayfare/core/manifold.hpp>

namespace wayfare::fitness_kernels {

/// Each column of `m` after a cross product with `v`.
template <class T>
[[nodiscard]] Eigen::Matrix<T, 3, 3> cross(const Eigen::Matrix<T, 3, 1>& v,
                                           const Eigen::Matrix<T, 3, 3>& m) {
  Eigen::Matrix<T, 3, 3> r;
  for (int j = 0; j < 3; ++j) r.col(j) = v.cross(m.col(j));
  return r;
}

/// Integrals since the beginning of an interval, in the axes of local level.
template <class T>
struct IntervalSums {
  using Vector3 = Eigen::Matrix<T, 3, 1>;
  using Matrix3 = Eigen::Matrix<T, 3, 3>;
  static constexpr std::size_t kTilt = 4;  ///< the attitude about local level

  double time_s, cubes_s3;    ///< since the beginning; sum of the cubes of its steps
  Matrix3 axes_s;             ///< integral of the axes
  Matrix3 axes, axes_before;  ///< of the unit, now and before the latest reading
  Vector3 turn;               ///< of velocity errors by Coriolis forces
  /// What a unit of each error at the beginning has done: of the sensors, in the order of
  /// InsNoise, and of the attitude about local level. On the attitude: those of the gyro.
  std::array<Matrix3, 2> attitude;
  std::array<Matrix3, 5> velocity, position;
  Eigen::Matrix<T, 12, 1> left;  ///< of a unit of each sensor error

  /// Of no time yet, with the unit's axes.
  void begin(const Matrix3& unit_axes) {
    time_s = cubes_s3 = 0.0;
    axes = axes_before = unit_axes;
    turn.setConstant(T(0));
    axes_s.setConstant(T(0));
    attitude.fill(axes_s);
    velocity.fill(axes_s);
    position.fill(axes_s);
    left.setConstant(T(1));
  }

  /// A reading. `impulse`: velocity gained in the unit's axes; `by`: effects of sensor errors
  /// there.
  void add(const Matrix3& axes_now, const Vector3& impulse, const std::array<Vector3, 4>& by,
           double dt_s) {
    const T dt = T(dt_s), half = T(0.5 * dt_s);
    const Vector3 gained = axes * impulse;
    const auto gain = [&](std::size_t b, const Matrix3& change) {
      position[b] += dt * velocity[b] + half * change;
      velocity[b] += change;
    };
    gain(0, -cross(gained, attitude[0]));
    gain(1, axes * by[1].asDiagonal());
    gain(2, -cross(gained, attitude[1]));
    gain(3, axes * by[3].asDiagonal());
    gain(kTilt, -skew(gained));
    for (std::size_t b = 0; b < 2; ++b) attitude[b] += axes_now * by[2 * b].asDiagonal();
    axes_s += half * (axes + axes_now);
    axes_before = axes;
    axes = axes_now;
    time_s += dt_s;
    cubes_s3 += dt_s * dt_s * dt_s;
  }

  /// Turns velocity errors by what the Coriolis forces did since `before`.
  void turn_since(const IntervalSums& before) {
    const T s = T(time_s - before.time_s);
    const Vector3 turned = turn - before.turn;
    for (std::size_t b = 0; b < velocity.size(); ++b) {
      const Matrix3 change = cross<T>(turned, T(0.5) * (before.velocity[b] + velocity[b]));
      position[b] += T(0.5) * s * change;
      velocity[b] += change;
    }
  }
};

/// Moves the velocities at the middle of three nodes so that the parabola through them has the
/// sum of all readings between; what they are by chance at one reading counts as one of many.
template <class T>
void smooth(const IntervalSums<T>& first, IntervalSums<T>& middle, const IntervalSums<T>& last) {
  const double a = middle.time_s - first.time_s, b = last.time_s - middle.time_s, t = a + b;
  // Simpson's rule for unequal panels, and what a sum of trapezoids has more than the integral.
  const double more = (last.cubes_s3 - first.cubes_s3) / 6.0;
  const double w0 = t * (2.0 * a - b) / (6.0 * a) + more / (a * t),
               w1 = t * t * t / (6.0 * a * b) - more / (a * b),
               w2 = t * (2.0 * b - a) / (6.0 * b) + more / (b * t);
  middle.axes = T(1.0 / w1) * (last.axes_s - first.axes_s - T(w0) * first.axes - T(w2) * last.axes);
  for (std::size_t k = 0; k < middle.velocity.size(); ++k)
    middle.velocity[k] = T(1.0 / w1) * (last.position[k] - first.position[k] -
                                        T(w0) * first.velocity[k] - T(w2) * last.velocity[k]);
}

}  // namespace wayfare::fitness_kernels
