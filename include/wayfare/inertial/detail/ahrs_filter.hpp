#pragma once

// The error-state Kalman filter of the AHRS, nine states. World axes are east, north, up.

#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <wayfare/core/detail/stumpff.hpp>
#include <wayfare/core/se3.hpp>
#include <wayfare/filter/sequential_update.hpp>
#include <wayfare/inertial/ahrs_parameters.hpp>
#include <wayfare/inertial/detail/padded_vector.hpp>

namespace wayfare {

/// States: attitude error as a rotation vector in *world* axes (true = exp(θ)·q), so that a heading
/// error stays one under rotation; gyro bias; horizontal velocity; magnetometer delay. The
/// accelerometer is integrated, and the bounded velocity levels the attitude.
template <class T>
class AhrsFilter {
 public:
  using Vector = Eigen::Matrix<T, 3, 1>;
  using Padded = PaddedVector<T>;
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
  [[nodiscard]] Rotation rotation() const { return axes_.template topRows<3>(); }
  [[nodiscard]] Padded in_world(const Padded& body) const {
    return axes_.col(0) * body[0] + axes_.col(1) * body[1] + axes_.col(2) * body[2];
  }
  [[nodiscard]] Vector bias() const { return bias_.unpadded(); }
  [[nodiscard]] Padded without_bias(const Padded& rate) const { return rate - bias_; }
  [[nodiscard]] const Eigen::Matrix<T, 2, 1>& velocity() const { return velocity_; }
  [[nodiscard]] T delay() const { return delay_; }
  [[nodiscard]] const Covariance& covariance() const { return p_; }
  [[nodiscard]] Covariance& covariance() { return p_; }

  void set_attitude(const SO3<T>& q) {
    q_ = q;
    // With q = (u, w): R = 2(u·uᵀ + w·(w·I + [u]×)) − I, from permutations of q.
    const Four v = q_.quaternion().coeffs(), twice = T(2) * v;
    const auto column = [&](int j, const Four& permuted, const Four& signs, const Four& unit) {
      axes_.col(j) = twice[j] * v + permuted.cwiseProduct(twice[3] * signs) - unit;
    };
    column(0, {v[3], v[2], v[1], v[0]}, {1, 1, -1, -1}, {1, 0, 0, 0});
    column(1, {v[2], v[3], v[0], v[1]}, {-1, 1, 1, -1}, {0, 1, 0, 0});
    column(2, {v[1], v[0], v[3], v[2]}, {1, -1, 1, -1}, {0, 0, 1, 0});
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
    const auto rotation = SO3<T>::between(this->rotation() * force, Vector::UnitZ());
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
  void rotate(const Padded& rate, T dt, T angle_variance, T bias_variance) {
    step_ += axes_ * dt;
    angle_variance_ += angle_variance;
    bias_variance_ += bias_variance;
    set_attitude(SO3<T>::from_unit(q_.quaternion() * small_turn(rate * dt, newton_step())));
  }
  /// Propagates the covariance over all rotations since the last call: in world axes they change
  /// the attitude's error by the bias and noise alone, so that one step is as exact as many.
  void propagate() {
    if (!(angle_variance_ > T(0)) && step_.isZero(T(0))) return;
    // θ' = θ − Σ R·dt·b: P_θb, P_θv and P_θδ from P_bb, P_bv and P_bδ, then P_θθ from the old and
    // the new P_θb. The zeros below step_ leave the fourth row as it is.
    Columns sum = attitude_with_bias();
    for (int j = kBias; j < kSize; ++j)
      p_.template head<4>(j) -= step_.col(0) * p_(kBias, j) + step_.col(1) * p_(kBias + 1, j) +
                                step_.col(2) * p_(kBias + 2, j);
    sum += attitude_with_bias();
    // The sum of step·oldᵀ and new·stepᵀ is symmetric.
    const Columns half = T(0.5) * step_ * sum.template topRows<3>().transpose();
    for (int j = 0; j < 3; ++j)
      for (int i = 0; i <= j; ++i) p_(i, j) -= half(i, j) + half(j, i);
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
  void turn(const Padded& rate, T dt, T angle_variance, T bias_variance) {
    rotate(rate, dt, angle_variance, bias_variance);
    propagate();
  }

  /// Integrates the specific force in world axes for dt.
  void accelerate(const Padded& force, T dt, T velocity_variance) {
    // v' = v + G·θ with G = −[a]×·dt, its first two rows.
    velocity_ += force.template head<2>() * dt;
    const T east = force[0] * dt, north = force[1] * dt, up = force[2] * dt;
    p_.template add_to<kVelocity>(IndexedRow<T, 1, 2>{{up, -north}});
    p_.template add_to<kVelocity + 1>(IndexedRow<T, 0, 2>{{-up, east}});
    p_(6, 6) += velocity_variance;
    p_(7, 7) += velocity_variance;
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
    set_attitude(
        SO3<T>::from_unit(small_turn({d[0], d[1], d[2]}, newton_step()) * q_.quaternion()));
    bias_ += Padded(d[3], d[4], d[5]);
    velocity_ += Eigen::Matrix<T, 2, 1>(d[6], d[7]);
    delay_ += d[8];
    pending_.fill(T(0));
    for (int i = 0; i < kSize; ++i)
      if (p_(i, i) < T(0)) p_.decouple(i, T(0));
  }

 private:
  using Four = Eigen::Matrix<T, 4, 1>;
  using Columns = Eigen::Matrix<T, 4, 3>;  // padded vectors

  /// The factor of one Newton step towards unit length, from the attitude before a turn, so that
  /// the turn need not wait for it.
  [[nodiscard]] T newton_step() const { return T(1.5) - T(0.5) * q_.quaternion().squaredNorm(); }
  /// stumpff<N>(a) for a ≤ 0.01. The first neglected term is below 3e-17, in single precision 2e-9.
  template <int N>
  [[nodiscard]] static T series(T a) {
    constexpr int kTerms = std::numeric_limits<T>::digits > 24 ? 5 : 3;
    T sum = T(1.0 / detail::factorial(N + 2 * (kTerms - 1)));
    for (int k = kTerms - 2; k >= 0; --k) sum = T(1.0 / detail::factorial(N + 2 * k)) - a * sum;
    return sum;
  }
  /// `length` times its exponential, from a short series if it is small.
  [[nodiscard]] static Eigen::Quaternion<T> small_turn(const Padded& angle, T length) {
    const T a = T(0.25) * angle.squaredNorm();
    if (a > T(0.01))
      return Eigen::Quaternion<T>(SO3<T>::exp(angle.unpadded()).quaternion().coeffs() * length);
    const T c = length * series<0>(a), k = T(0.5) * length * series<1>(a);
    return Eigen::Quaternion<T>(k * angle + c * Four(0, 0, 0, 1));
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

  /// P_θb, above a row of no interest.
  [[nodiscard]] Columns attitude_with_bias() {
    Columns result;
    for (int j = 0; j < 3; ++j) result.col(j) = p_.template head<4>(kBias + j);
    return result;
  }

  SO3<T> q_;
  Columns axes_ = Columns::Identity();  // of the body in the world, the rotation's columns
  Padded bias_;
  Eigen::Matrix<T, 2, 1> velocity_ = Eigen::Matrix<T, 2, 1>::Zero();
  T delay_ = T(0);
  Covariance p_;
  std::array<T, kSize> pending_{};
  Columns step_ = Columns::Zero();  // since propagate(): Σ R·dt
  T angle_variance_ = T(0), bias_variance_ = T(0);
};

}  // namespace wayfare
