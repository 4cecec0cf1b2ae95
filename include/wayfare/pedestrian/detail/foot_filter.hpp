#pragma once

// The error-state Kalman filter of the foot-mounted tracker, fifteen states. World axes: z up, x
// and y from the sensor's initial heading.

#include <cmath>

#include <Eigen/Core>
#include <Eigen/LU>

#include <wayfare/core/se3.hpp>
#include <wayfare/filter/sequential_update.hpp>

namespace wayfare {

/// Position, velocity, attitude (its error a rotation vector in world axes, true = exp(θ)·q) and
/// the biases of gyro and accelerometer.
class FootFilter {
 public:
  using Vector = Eigen::Vector3d;                          ///< of three components
  static constexpr int kPosition = 0,                      ///< place of the errors
      kVelocity = 3,                                       ///< place of the errors
      kAttitude = 6,                                       ///< place of the errors
      kRateBias = 9,                                       ///< place of the errors
      kForceBias = 12,                                     ///< place of the errors
      kSize = 15;                                          ///< number of errors
  using Covariance = Eigen::Matrix<double, kSize, kSize>;  ///< of the errors
  using Error = Eigen::Matrix<double, kSize, 1>;           ///< of the state

  [[nodiscard]] const Vector& position() const { return position_; }    ///< m, z up, from the start
  [[nodiscard]] const Vector& velocity() const { return velocity_; }    ///< m/s
  [[nodiscard]] const SO3d& q_world_foot() const { return q_; }         ///< attitude
  [[nodiscard]] const Vector& rate_bias() const { return rate_bias_; }  ///< rad/s, the unit's axes
  [[nodiscard]] const Vector& force_bias() const { return force_bias_; }  ///< m/s², the unit's axes
  [[nodiscard]] const Covariance& covariance() const { return p_; }       ///< of the errors

  /// Sets a state; its error becomes independent of all others, with this variance per axis.
  void set_position(const Vector& p, double variance) {
    position_ = p;
    decouple(kPosition, Vector::Constant(variance));
  }
  /// m/s.
  void set_velocity(const Vector& v, double variance) {
    velocity_ = v;
    decouple(kVelocity, Vector::Constant(variance));
  }
  /// Variances about the world's axes, rad².
  void set_attitude(const SO3d& q, const Vector& variances) {
    q_ = q;
    decouple(kAttitude, variances);
  }
  /// Of both biases, per axis; the biases stay.
  void set_bias_variances(double rate, double force) {
    decouple(kRateBias, Vector::Constant(rate));
    decouple(kForceBias, Vector::Constant(force));
  }

  /// Variances added per axis by a step; `missed_turn`: covariance of a rotation clipped by the
  /// gyro, world axes.
  struct Noise {
    double position = 0.0,                                  ///< m²
        velocity = 0.0,                                     ///< (m/s)²
        angle = 0.0,                                        ///< rad²
        rate_bias = 0.0,                                    ///< (rad/s)²
        force_bias = 0.0;                                   ///< (m/s²)²
    Eigen::Matrix3d missed_turn = Eigen::Matrix3d::Zero();  ///< rad²
  };

  /// Strapdown step over dt with its mean readings.
  void predict(const Vector& rate, const Vector& force, double gravity, double dt) {
    const Vector turn = (rate - rate_bias_) * dt;
    const Eigen::Matrix3d middle = (q_ * SO3d::exp(0.5 * turn)).matrix();
    const Vector world = middle * (force - force_bias_);
    const Vector a = world - Vector(0.0, 0.0, gravity);
    q_ = q_ * SO3d::exp(turn);
    position_ += velocity_ * dt + 0.5 * a * dt * dt;
    velocity_ += a * dt;
    propagate(dt, -dt * skew<double>(world), -dt * middle);
  }
  /// To the covariance.
  void add_noise(const Noise& n) {
    p_.diagonal().segment<3>(kPosition).array() += n.position;
    p_.diagonal().segment<3>(kVelocity).array() += n.velocity;
    p_.diagonal().segment<3>(kAttitude).array() += n.angle;
    p_.diagonal().segment<3>(kRateBias).array() += n.rate_bias;
    p_.diagonal().segment<3>(kForceBias).array() += n.force_bias;
    p_.block<3, 3>(kAttitude, kAttitude) += n.missed_turn;
  }

  /// Updates the three states from `First` on with `value`, of this variance per axis.
  template <int First>
  void observe(const Vector& value, double variance) {
    move(update<First>(p_, value - state<First>(), variance));
  }

  /// Zero-velocity update by probabilistic data association (Bar-Shalom et al. 2009): stance,
  /// velocity zero with `variance` and prior log odds `log_odds`, or motion with `wide_variance`.
  /// Returns the probability of stance.
  double update_zero_velocity(double variance, double wide_variance, double log_odds) {
    const Eigen::Matrix3d s = innovation_covariance<kVelocity>(variance);
    const Vector off = -velocity_;
    const double log_ratio =
        log_density(off, s) - log_density(off, innovation_covariance<kVelocity>(wide_variance));
    const double stance = 1.0 / (1.0 + std::exp(-(log_ratio + log_odds)));
    if (!(stance > 1e-9)) return 0.0;
    Covariance standing = p_;
    const Error step = update<kVelocity>(standing, off, variance);
    p_ += stance * (standing - p_ + (1.0 - stance) * step * step.transpose());
    move(stance * step);
    return stance;
  }

  /// Shifts the position, by an external constraint; the covariance is unchanged.
  void shift(const Vector& by) { position_ += by; }

  /// Updates the component of the position along the unit vector `unit` with `value`.
  void observe_along(const Vector& unit, double value, double variance) {
    Error correction = Error::Zero();
    DenseCovariance<Covariance> covariance{p_};
    sequential_update(covariance, correction,
                      IndexedRow<double, 0, 1, 2>{unit.x(), unit.y(), unit.z()},
                      value - unit.dot(position_), variance);
    move(correction);
  }

 private:
  template <int First>
  [[nodiscard]] const Vector& state() const {
    static_assert(First == kPosition || First == kVelocity || First == kRateBias);
    return First == kPosition ? position_ : First == kVelocity ? velocity_ : rate_bias_;
  }
  template <int First>
  [[nodiscard]] Eigen::Matrix3d innovation_covariance(double variance) const {
    return p_.block<3, 3>(First, First) + variance * Eigen::Matrix3d::Identity();
  }
  /// Updates `p` with the innovations of three states from `First` on; returns the correction.
  template <int First>
  static Error update(Covariance& p, const Vector& innovation, double variance) {
    Error correction = Error::Zero();
    DenseCovariance<Covariance> covariance{p};
    sequential_update(covariance, correction, IndexedRow<double, First>{1.0}, innovation.x(),
                      variance);
    sequential_update(covariance, correction, IndexedRow<double, First + 1>{1.0}, innovation.y(),
                      variance);
    sequential_update(covariance, correction, IndexedRow<double, First + 2>{1.0}, innovation.z(),
                      variance);
    return correction;
  }
  [[nodiscard]] static double log_density(const Vector& v, const Eigen::Matrix3d& s) {
    return -0.5 * (v.dot(s.inverse() * v) + std::log(s.determinant()));
  }

  /// P ← Φ P Φᵀ; Φ is the identity but for the velocity's part in the position, the attitude's in
  /// the velocity, and that of the biases in both. As P is symmetric, the columns of P Φᵀ are
  /// those of Φ P after a transposition.
  void propagate(double dt, const Eigen::Matrix3d& velocity_by_attitude,
                 const Eigen::Matrix3d& by_bias) {
    const auto multiply = [&] {
      p_.middleCols<3>(kPosition) += dt * p_.middleCols<3>(kVelocity);
      p_.middleCols<3>(kVelocity) +=
          p_.middleCols<3>(kAttitude).lazyProduct(velocity_by_attitude.transpose()) +
          p_.middleCols<3>(kForceBias).lazyProduct(by_bias.transpose());
      p_.middleCols<3>(kAttitude) += p_.middleCols<3>(kRateBias).lazyProduct(by_bias.transpose());
    };
    multiply();
    p_.transposeInPlace();
    multiply();
  }

  void move(const Error& d) {
    position_ += d.segment<3>(kPosition);
    velocity_ += d.segment<3>(kVelocity);
    q_ = SO3d::exp(d.segment<3>(kAttitude)) * q_;
    rate_bias_ += d.segment<3>(kRateBias);
    force_bias_ += d.segment<3>(kForceBias);
    p_ = (0.5 * (p_ + p_.transpose())).eval();
  }
  void decouple(int first, const Vector& variances) {
    p_.middleRows<3>(first).setZero();
    p_.middleCols<3>(first).setZero();
    p_.diagonal().segment<3>(first) = variances;
  }

  SO3d q_;
  Vector position_ = Vector::Zero(), velocity_ = Vector::Zero();
  Vector rate_bias_ = Vector::Zero(), force_bias_ = Vector::Zero();
  Covariance p_ = Covariance::Zero();
};

}  // namespace wayfare
