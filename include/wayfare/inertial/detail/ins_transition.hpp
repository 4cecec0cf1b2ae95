#pragma once

// Covariance propagation of the 23-state filter, exploiting the sparsity of Φ.

#include <algorithm>

#include <Eigen/Core>

#include <wayfare/filter/gauss_markov.hpp>
#include <wayfare/inertial/ins_state.hpp>

namespace wayfare {

/// The non-trivial blocks of Φ, and the process noise of one step.
template <class T, int Offsets = 0>
struct InsTransition {
  using Vector3 = Eigen::Matrix<T, 3, 1>;
  using Matrix3 = Eigen::Matrix<T, 3, 3>;
  static constexpr int kDof = ins_state::kSize + Offsets;

  Vector3 half_dt;        ///< position on the plane per sum of both velocities
  Vector3 velocity_turn;  ///< velocity's block of itself is I + [velocity_turn]×
  Matrix3 velocity_attitude, velocity_accel_bias;
  /// Columns of velocity_accel_bias times this are those of the accelerometer scale.
  Vector3 scale_force;
  Matrix3 attitude_attitude;
  Vector3 attitude_gyro_bias, attitude_gyro_scale;  ///< diagonals
  Eigen::Matrix<T, 12, 1> kept;                     ///< decay of the sensor errors, diagonal
  T dt_s;

  Matrix3 velocity_noise;
  Vector3 attitude_noise;
  Eigen::Matrix<T, 12, 1> error_noise;
  ClockStep<T> clock_noise;
  T clock_offset_noise;

  /// P ← Φ P Φᵀ + Q, `p` column-major, both triangles in and out. Skips the zeros of Φ and computes
  /// one triangle of symmetric blocks. Plain loops over columns, vectorised by compilers for
  /// numbers and by themselves for packs.
  void propagate(T* p) const {
    using namespace ins_state;
    constexpr int n = kDof;
    T rows[9][n];  // Φ P, the navigation part
    left_product(p, rows);
    T nav[9][9];
    right_product(rows, nav);
    for (int i = 0; i < 9; ++i) {
      for (int j = 0; j <= i; ++j) p[n * i + j] = p[n * j + i] = nav[i][j];
    }
    for (int j = 0; j < 12; ++j) {
      for (int i = 0; i < 9; ++i) {
        p[n * (9 + j) + i] = p[n * i + 9 + j] = rows[i][9 + j] * kept[j];
      }
    }
    sensor_errors(p);
    clock(p, rows);
    add_noise(p);
  }
  template <class Square>
  requires requires(Square& p) { p.data(); }
  void propagate(Square& p) const { propagate(p.data()); }

  /// The same Φ and Q as dense matrices.
  [[nodiscard]] Eigen::Matrix<T, kDof, kDof> phi() const {
    using namespace ins_state;
    Eigen::Matrix<T, kDof, kDof> f = Eigen::Matrix<T, kDof, kDof>::Identity();
    f.template block<3, 3>(kVelocity, kVelocity) += skew(velocity_turn);
    f.template block<3, 3>(kVelocity, kAttitude) = velocity_attitude;
    f.template block<3, 3>(kVelocity, kAccelBias) = velocity_accel_bias;
    f.template block<3, 3>(kVelocity, kAccelScale) = velocity_accel_bias * scale_force.asDiagonal();
    f.template block<3, 3>(kAttitude, kAttitude) = attitude_attitude;
    for (int i = 0; i < 3; ++i) {
      f(kAttitude + i, kGyroBias + i) = attitude_gyro_bias[i];
      f(kAttitude + i, kGyroScale + i) = attitude_gyro_scale[i];
    }
    for (int i = 0; i < 12; ++i) f(kGyroBias + i, kGyroBias + i) = kept[i];
    f(kClock, kClock + 1) = dt_s;
    for (int i = 0; i < 3; ++i) {
      f.row(kPosition + i) += half_dt[i] * f.row(kVelocity + i);
      f(kPosition + i, kVelocity + i) += half_dt[i];
    }
    return f;
  }
  [[nodiscard]] Eigen::Matrix<T, kDof, kDof> q() const {
    Eigen::Matrix<T, kDof, kDof> noise = Eigen::Matrix<T, kDof, kDof>::Zero();
    add_noise(noise.data());
    return noise;
  }

 private:
  void left_product(const T* p, T (*rows)[kDof]) const {
    using namespace ins_state;
    constexpr int n = kDof;
    const auto column = [p](int i) { return p + n * i; };
    T accel[3][n];  // rows of P of accelerometer bias and scale combined
    for (int i = 0; i < 3; ++i) {
      const T *b = column(kAccelBias + i), *s = column(kAccelScale + i);
      const T force = scale_force[i];
      for (int c = 0; c < n; ++c) accel[i][c] = b[c] + force * s[c];
    }
    for (int i = 0; i < 3; ++i) {
      const int j = (i + 1) % 3, k = (i + 2) % 3;
      T *velocity = rows[kVelocity + i], *attitude = rows[kAttitude + i],
        *position = rows[kPosition + i];
      const T *v = column(kVelocity + i), *vj = column(kVelocity + j), *vk = column(kVelocity + k);
      const T *x = column(kPosition + i), *a0 = column(kAttitude);
      const T *gb = column(kGyroBias + i), *gs = column(kGyroScale + i);
      const T tj = velocity_turn[j], tk = velocity_turn[k], half = half_dt[i];
      const T va0 = velocity_attitude(i, 0), va1 = velocity_attitude(i, 1),
              va2 = velocity_attitude(i, 2);
      const T vb0 = velocity_accel_bias(i, 0), vb1 = velocity_accel_bias(i, 1),
              vb2 = velocity_accel_bias(i, 2);
      for (int c = 0; c < n; ++c) {
        velocity[c] = v[c] + (tj * vk[c] - tk * vj[c]) +
                      (va0 * a0[c] + va1 * a0[n + c] + va2 * a0[2 * n + c]) +
                      (vb0 * accel[0][c] + vb1 * accel[1][c] + vb2 * accel[2][c]);
      }
      for (int c = 0; c < n; ++c) position[c] = x[c] + half * (v[c] + velocity[c]);
      const T aa0 = attitude_attitude(i, 0), aa1 = attitude_attitude(i, 1),
              aa2 = attitude_attitude(i, 2);
      const T by_bias = attitude_gyro_bias[i], by_scale = attitude_gyro_scale[i];
      for (int c = 0; c < n; ++c) {
        attitude[c] = (aa0 * a0[c] + aa1 * a0[n + c] + aa2 * a0[2 * n + c]) +
                      (by_bias * gb[c] + by_scale * gs[c]);
      }
    }
  }

  /// Row `w` of Φ P times row i of Φ's velocity block; `accel`: bias and scale combined.
  [[nodiscard]] T velocity_entry(const T* w, const T* accel, int i) const {
    using namespace ins_state;
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    T sum = w[kVelocity + i] +
            (velocity_turn[j] * w[kVelocity + k] - velocity_turn[k] * w[kVelocity + j]);
    for (int m = 0; m < 3; ++m) sum += velocity_attitude(i, m) * w[kAttitude + m];
    for (int m = 0; m < 3; ++m) sum += velocity_accel_bias(i, m) * accel[m];
    return sum;
  }
  [[nodiscard]] T attitude_entry(const T* w, int i) const {
    using namespace ins_state;
    T sum = attitude_gyro_bias[i] * w[kGyroBias + i] + attitude_gyro_scale[i] * w[kGyroScale + i];
    for (int j = 0; j < 3; ++j) sum += attitude_attitude(i, j) * w[kAttitude + j];
    return sum;
  }

  /// The lower triangle of (Φ P Φᵀ)'s navigation part.
  void right_product(const T (*rows)[kDof], T (*nav)[9]) const {
    using namespace ins_state;
    for (int j = 0; j < 6; ++j) {
      T accel[3];
      for (int m = 0; m < 3; ++m)
        accel[m] = rows[j][kAccelBias + m] + scale_force[m] * rows[j][kAccelScale + m];
      for (int i = std::max(0, j - kVelocity); i < 3; ++i)
        nav[kVelocity + i][j] = velocity_entry(rows[j], accel, i);
    }
    for (int j = 0; j < 9; ++j) {
      for (int i = std::max(0, j - kAttitude); i < 3; ++i)
        nav[kAttitude + i][j] = attitude_entry(rows[j], i);
    }
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j <= i; ++j)
        nav[i][j] = rows[j][i] + half_dt[i] * (rows[j][kVelocity + i] + nav[kVelocity + i][j]);
    }
  }

  void sensor_errors(T* p) const {
    constexpr int n = kDof;
    for (int j = 0; j < 12; ++j) {
      for (int i = 0; i <= j; ++i) {
        const T next = p[n * (9 + j) + 9 + i] * (kept[i] * kept[j]);
        p[n * (9 + j) + 9 + i] = p[n * (9 + i) + 9 + j] = next;
      }
    }
  }

  void clock(T* p, const T (*rows)[kDof]) const {
    using namespace ins_state;
    constexpr int n = kDof;
    const auto set = [p](int i, int j, const T& value) { p[n * i + j] = p[n * j + i] = value; };
    for (int c = kClock; c < n; ++c) {
      for (int i = 0; i < 9; ++i) {
        set(i, c, c == kClock ? rows[i][c] + dt_s * rows[i][c + 1] : rows[i][c]);
      }
      for (int i = 0; i < 12; ++i) {
        const T* e = p + n * c + 9;
        set(9 + i, c, kept[i] * (c == kClock ? e[i] + dt_s * e[n + i] : e[i]));
      }
    }
    constexpr int b = kClock, d = kClock + 1;
    for (int c = d + 1; c < n; ++c) set(b, c, p[n * b + c] + dt_s * p[n * d + c]);
    const T cross = p[n * d + b] + dt_s * p[n * d + d];
    p[n * b + b] += dt_s * (p[n * d + b] + cross);
    set(b, d, cross);
  }

  void add_noise(T* p) const {
    using namespace ins_state;
    constexpr int n = kDof;
    for (int j = 0; j < 3; ++j) {
      for (int i = 0; i < 3; ++i) {
        p[n * (kVelocity + j) + kVelocity + i] += velocity_noise(std::min(i, j), std::max(i, j));
      }
      p[(n + 1) * (kAttitude + j)] += attitude_noise[j];
    }
    for (int i = 0; i < 12; ++i) p[(n + 1) * (kGyroBias + i)] += error_noise[i];
    p[(n + 1) * kClock] += clock_noise.bias_variance;
    p[(n + 1) * (kClock + 1)] += clock_noise.drift_variance;
    p[n * kClock + kClock + 1] += clock_noise.covariance;
    p[n * (kClock + 1) + kClock] += clock_noise.covariance;
    for (int c = kClock + 2; c < n; ++c) p[(n + 1) * c] += clock_offset_noise;
  }
};

}  // namespace wayfare
