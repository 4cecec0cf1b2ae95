#pragma once

// The error-state Kalman filter of the AHRS, nine states. World axes are east, north, up.

#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <wayfare/core/se3.hpp>
#include <wayfare/filter/sequential_update.hpp>
#include <wayfare/inertial/ahrs_parameters.hpp>

namespace wayfare {

/// States: attitude error as a rotation vector in *world* axes (true = exp(θ)·q), so that a heading
/// error stays one under rotation; gyro bias; horizontal velocity; magnetometer delay. The
/// accelerometer is integrated, and the bounded velocity levels the attitude.
template <class T>
class AhrsFilter {
 public:
  using Vector = Eigen::Matrix<T, 3, 1>;
  using Rotation = Eigen::Matrix<T, 3, 3>;
  /// Forces and fields correct the attitude by their means over these times (four and three
  /// readings at 100 Hz), in world axes, in which they hardly change with the body's rotation.
  /// Fields more often: disturbed ones are found in time.
  static constexpr T kUpdate_s = T(0.0395), kFieldUpdate_s = T(0.0295);
  /// Variance of an unknown angle, rad².
  static constexpr T kUnknown = T(10);
  static constexpr int kAttitude = 0, kBias = 3, kVelocity = 6, kDelay = 8, kSize = 9;
  using Covariance = SymmetricMatrix<T, kSize>;

  [[nodiscard]] const SO3<T>& q_enu_body() const { return q_; }
  [[nodiscard]] const Rotation& rotation() const { return r_; }
  [[nodiscard]] const Vector& bias() const { return bias_; }
  [[nodiscard]] const Eigen::Matrix<T, 2, 1>& velocity() const { return velocity_; }
  [[nodiscard]] T delay() const { return delay_; }
  [[nodiscard]] const Covariance& covariance() const { return p_; }
  [[nodiscard]] Covariance& covariance() { return p_; }

  void set_attitude(const SO3<T>& q) {
    q_ = q;
    r_ = q_.matrix();
  }
  void set_velocity(const Eigen::Matrix<T, 2, 1>& v) { velocity_ = v; }
  void set_bias(const Vector& b) { bias_ = b; }
  void set_delay(T delay) { delay_ = delay; }

  /// Resets bias and delay to their initial values.
  void forget_bias(const AhrsParameters& p) {
    for (int i = 0; i < 3; ++i) p_.decouple(kBias + i, T(p.bias_sigma * p.bias_sigma));
    const double delay = p.use_magnetometer ? p.magnetometer_delay_sigma_s : 0.0;
    p_.decouple(kDelay, T(delay * delay));
    bias_.setZero();
    delay_ = T(p.magnetometer_delay_s);
  }
  void forget_velocity(T variance) {
    velocity_.setZero();
    p_.decouple(kVelocity, variance);
    p_.decouple(kVelocity + 1, variance);
  }
  /// Applies the smallest rotation that makes `force` point up. The tilt then has standard
  /// deviation `sigma`; the heading variance grows with the rotation angle.
  void level(const Vector& force, T sigma) {
    const auto rotation = SO3<T>::between(r_ * force, Vector::UnitZ());
    set_attitude(rotation * q_);
    const T angle = rotation.log().norm();
    const T heading = p_(2, 2) + T(0.25) * angle * angle;
    p_.decouple(0, sigma * sigma);
    p_.decouple(1, sigma * sigma);
    p_.decouple(2, heading);
  }
  /// Rotates the attitude about the vertical by `angle`, counter-clockwise; the heading then has
  /// standard deviation `sigma`, or is unknown.
  void turn_heading(T angle, T sigma) {
    set_attitude(SO3<T>::exp({T(0), T(0), angle}) * q_);
    velocity_ = Eigen::Rotation2D<T>(angle) * velocity_;
    p_.decouple(2, std::min(sigma * sigma, kUnknown));
  }

  /// Rotates by the body's rate (bias subtracted) for dt, in which each angle gains
  /// `angle_variance` and each bias `bias_variance`. The covariance follows in propagate().
  void rotate(const Vector& rate, T dt, T angle_variance, T bias_variance) {
    step_ += r_ * dt;
    angle_variance_ += angle_variance;
    bias_variance_ += bias_variance;
    set_attitude(q_ * small_turn(rate.x() * dt, rate.y() * dt, rate.z() * dt));
  }
  /// Propagates the covariance over all rotations since the last call: in world axes they change
  /// the attitude's error by the bias and noise alone, so that one step is as exact as many.
  void propagate() {
    if (!(angle_variance_ > T(0)) && step_.isZero(T(0))) return;
    // θ' = θ − Σ R·dt·b: P_bb, then its products, then P_θθ from the old and the new P_θb.
    const Rotation old_cross = attitude_with_bias();
    for (int j = kBias; j < kSize; ++j) {
      const Vector change = step_ * Vector(p_(kBias, j), p_(kBias + 1, j), p_(kBias + 2, j));
      for (int i = 0; i < 3; ++i) p_(i, j) -= change[i];
    }
    const Rotation sum = old_cross + attitude_with_bias();
    // The sum of step·oldᵀ and new·stepᵀ is symmetric.
    for (int j = 0; j < 3; ++j)
      for (int i = 0; i <= j; ++i)
        p_(i, j) -= T(0.5) * (step_.row(i).dot(sum.row(j)) + step_.row(j).dot(sum.row(i)));
    for (int i = 0; i < 3; ++i) {
      p_(i, i) += angle_variance_;
      if (p_(i, i) > kUnknown) p_.decouple(i, kUnknown);
      p_(kBias + i, kBias + i) += bias_variance_;
    }
    step_.setZero();
    angle_variance_ = bias_variance_ = T(0);
  }
  /// Of the heading, as after propagate().
  [[nodiscard]] T heading_variance() const {
    const Vector step = step_.row(2);
    T variance = p_(2, 2) + angle_variance_;
    for (int i = 0; i < 3; ++i) {
      const Vector bias(p_(kBias, kBias + i), p_(kBias + 1, kBias + i), p_(kBias + 2, kBias + i));
      variance += step[i] * (step.dot(bias) - T(2) * p_(2, kBias + i));
    }
    return std::min(variance, kUnknown);
  }
  /// Both.
  void turn(const Vector& rate, T dt, T angle_variance, T bias_variance) {
    rotate(rate, dt, angle_variance, bias_variance);
    propagate();
  }

  /// Integrates the specific force in world axes for dt.
  void accelerate(const Vector& force, T dt, T velocity_variance) {
    // v' = v + G·θ with G = −[a]×·dt, its first two rows.
    velocity_ += force.template head<2>() * dt;
    const T east = force[0] * dt, north = force[1] * dt, up = force[2] * dt;
    const auto g = [&](int row, const T& x, const T& y, const T& z) {
      return row == 0 ? up * y - north * z : east * z - up * x;
    };
    const T old[2][2] = {{g(0, p_(0, 6), p_(1, 6), p_(2, 6)), g(0, p_(0, 7), p_(1, 7), p_(2, 7))},
                         {T(0), g(1, p_(0, 7), p_(1, 7), p_(2, 7))}};
    const T old10 = g(1, p_(0, 6), p_(1, 6), p_(2, 6));
    for (const int j : {0, 1, 2, 3, 4, 5, 8})
      for (int row = 0; row < 2; ++row)
        p_(kVelocity + row, j) += g(row, p_(0, j), p_(1, j), p_(2, j));
    p_(6, 6) += old[0][0] + g(0, p_(0, 6), p_(1, 6), p_(2, 6)) + velocity_variance;
    p_(7, 7) += old[1][1] + g(1, p_(0, 7), p_(1, 7), p_(2, 7)) + velocity_variance;
    p_(6, 7) += old10 + g(0, p_(0, 7), p_(1, 7), p_(2, 7));
  }

  /// One scalar measurement with Jacobian `h` and variance `r`; `innovation` is measured minus
  /// predicted at the estimate after the last apply(). Returns the normalised innovation squared.
  template <int... Index>
  T observe(const IndexedRow<T, Index...>& h, T innovation, T r) {
    return sequential_update(p_, pending_, h, innovation, r);
  }
  /// The same if the measurement error has covariance −`shared`, rad², with the heading error, a
  /// result of consistent_share(); the heading's coefficient in `h` is one.
  template <int... Index>
  T observe_shared(const IndexedRow<T, Index...>& h, T innovation, T r, T shared) {
    auto expected = expected_innovation(p_, h);
    expected.variance -= T(2) * shared;
    expected.cross[kAttitude + 2] -= shared;
    return sequential_update(p_, pending_, h, expected, innovation, r);
  }
  /// The part of `shared` that an error of variance `r` ≥ `shared` can have in common with the
  /// heading error: state and measurement have a joint covariance only if shared² ≤ r·c, with c the
  /// heading's variance given all other states (Schur complement). Beyond that, other measurements
  /// have since removed noise from the heading, and at most c is left of it.
  [[nodiscard]] T consistent_share(T shared, T r) const {
    const T own = own_heading_variance();
    return shared * shared > r * own ? own : shared;
  }
  /// Variance h P hᵀ of the state error along the row.
  template <int... Index>
  [[nodiscard]] T variance_of(const IndexedRow<T, Index...>& h) const {
    return expected_innovation(p_, h).variance;
  }

  /// Applies the correction accumulated since the last call to the estimate.
  void apply() {
    const auto& d = pending_;
    set_attitude(small_turn(d[0], d[1], d[2]) * q_);
    bias_ += Vector(d[3], d[4], d[5]);
    velocity_ += Eigen::Matrix<T, 2, 1>(d[6], d[7]);
    delay_ += d[8];
    pending_.fill(T(0));
    for (int i = 0; i < kSize; ++i)
      if (p_(i, i) < T(0)) p_.decouple(i, T(0));
  }

 private:
  /// exp((x, y, z)) to 1e-15, from a short series if it is small. Numbers stay in registers, where
  /// a vector would be written as three and read as two of them.
  [[nodiscard]] static SO3<T> small_turn(T x, T y, T z) {
    const T a = T(0.25) * (x * x + y * y + z * z);
    if (a > T(0.01)) return SO3<T>::exp({x, y, z});
    const T c =
        T(1) - a * (T(1.0 / 2) - a * (T(1.0 / 24) - a * (T(1.0 / 720) - a * T(1.0 / 40320))));
    const T k = T(0.5) - a * (T(1.0 / 12) - a * (T(1.0 / 240) - a * T(1.0 / 10080)));
    return SO3<T>::from_unit(Eigen::Quaternion<T>(c, k * x, k * y, k * z));
  }

  /// Variance of the heading error given the errors of all other states.
  [[nodiscard]] T own_heading_variance() const {
    Covariance rest = p_;
    for (int i = 0; i < kSize; ++i) {
      if (i == kAttitude + 2) continue;
      // A state given by those before it, but for rounding, adds nothing.
      if (!(rest(i, i) > T(16) * std::numeric_limits<T>::epsilon() * p_(i, i))) continue;
      typename Covariance::Vector column;
      for (int j = 0; j < kSize; ++j) column[static_cast<std::size_t>(j)] = rest(j, i);
      rest.subtract_outer(column, T(1) / rest(i, i));
    }
    return std::max(rest(2, 2), T(0));
  }

  [[nodiscard]] Rotation attitude_with_bias() const {
    return (Rotation() << p_(0, 3), p_(0, 4), p_(0, 5), p_(1, 3), p_(1, 4), p_(1, 5), p_(2, 3),
            p_(2, 4), p_(2, 5))
        .finished();
  }

  SO3<T> q_;
  Rotation r_ = Rotation::Identity();
  Vector bias_ = Vector::Zero();
  Eigen::Matrix<T, 2, 1> velocity_ = Eigen::Matrix<T, 2, 1>::Zero();
  T delay_ = T(0);
  Covariance p_;
  std::array<T, kSize> pending_{};
  Rotation step_ = Rotation::Zero();  // since propagate(): Σ R·dt
  T angle_variance_ = T(0), bias_variance_ = T(0);
};

}  // namespace wayfare
