#pragma once

// What a gyro's heading drifts, by a magnetometer whose iron nobody calibrated: the iron's field
// turns with the unit, the Earth's does not.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include <Eigen/Core>

#include <wayfare/core/so3.hpp>
#include <wayfare/filter/symmetric_matrix.hpp>
#include <wayfare/inertial/attitude.hpp>
#include <wayfare/inertial/detail/sample_clock.hpp>

namespace wayfare {

/// Off with an offset of zero.
struct MagneticHeadingDriftParameters {
  /// What is unknown of the magnetometer's offset, µT along each axis.
  double offset_sigma_uT = 0.0;
  /// And of the Earth's field, µT.
  double field_sigma_uT = 60.0;
  /// How far the field is bent where one walks: standard deviation, µT, and correlation time, s.
  double disturbance_uT = 4.0;
  double disturbance_s = 2.0;
  /// What is off by so many standard deviations is another field; one that lasts this long, s, is
  /// taken for the Earth's.
  double gate_sigmas = 5.0;
  double relearn_s = 20.0;
  /// Gyro's bias about the vertical at the start, rad/s, its walk, rad/s/√s, and noise, rad/s/√Hz.
  double bias_sigma = 0.3 * kDegree;
  double bias_walk = 0.002 * kDegree;
  double rate_noise = 0.1 * kDegree;
  double spacing_s = 0.1;  ///< from one reading that counts to the next

 private:
  static constexpr double kDegree = 0.017453292519943295;
};

/// An extended Kalman filter of eight states: drift of the heading and its rate, the Earth's field
/// in world axes, the offset in the unit's. World axes are those of the gyro's first heading, from
/// which the drift is counted: what the offset takes long to be told from the field for does the
/// heading no harm. It takes turns to tell them apart: after minutes of going straight ahead its
/// variances are too small.
class MagneticHeadingDrift {
 public:
  explicit MagneticHeadingDrift(const MagneticHeadingDriftParameters& p) : p_(p) {
    forget(kDrift, 0.0);
    forget(kRate, p.bias_sigma);
    forget_fields();
  }

  [[nodiscard]] bool on() const { return p_.offset_sigma_uT > 0.0; }

  /// A reading in the unit's axes, µT, or NaN, and the attitude by gyro and accelerometer alone,
  /// world z up.
  UpdateStatus add(LogTime time, const SO3d& q_world_body, const Eigen::Vector3d& field_uT) {
    const auto verdict = clock_.check(time);
    if (verdict == SampleClock::Verdict::late) return report_.note(UpdateStatus::late);
    const double step = verdict == SampleClock::Verdict::first ? 0.0 : clock_.step_s();
    if (step > kLongest_s) forget(kDrift, kLost);
    since_s_ += step;
    if (!field_uT.allFinite()) return report_.note(UpdateStatus::missing);
    if (since_s_ < p_.spacing_s) return report_.note(UpdateStatus::waiting);
    const double dt = since_s_;
    since_s_ = 0.0;
    drift_on(dt);
    return report_.note(observe(q_world_body.matrix(), field_uT, std::min(dt, kLongest_s)));
  }

  /// By how much the gyro's heading is to be turned on, counter-clockwise, rad, and its variance.
  [[nodiscard]] double correction() const { return x_[kDrift]; }
  [[nodiscard]] double variance() const { return covariance_(kDrift, kDrift); }
  /// How fast it drifts, rad/s.
  [[nodiscard]] double rate_radps() const { return x_[kRate]; }
  [[nodiscard]] Eigen::Vector3d offset_uT() const { return x_.tail<3>(); }
  [[nodiscard]] Eigen::Vector3d offset_sigma_uT() const {
    const auto& p = covariance_;
    return Eigen::Vector3d(p(5, 5), p(6, 6), p(7, 7)).cwiseMax(0.0).cwiseSqrt();
  }
  [[nodiscard]] const SensorReport& report() const { return report_; }

 private:
  static constexpr int kDrift = 0, kRate = 1, kField = 2, kOffset = 5, kSize = 8;
  static constexpr double kLongest_s = 1.0;  ///< a pause through which the gyro is not followed
  static constexpr double kLost = 1.0;       ///< rad, beyond which the drift is as good as any

  void forget(int i, double sigma) { covariance_.decouple(i, sigma * sigma); }
  void forget_fields() {
    for (int i = 0; i < 3; ++i) {
      forget(kField + i, p_.field_sigma_uT);
      forget(kOffset + i, p_.offset_sigma_uT);
    }
  }

  void drift_on(double dt) {
    auto& p = covariance_;
    x_[kDrift] += x_[kRate] * dt;
    const double shared = p(kDrift, kRate);
    p(kDrift, kDrift) += dt * (2.0 * shared + dt * p(kRate, kRate));
    for (int j = kRate; j < kSize; ++j) p(kDrift, j) += dt * p(kRate, j);
    p(kDrift, kDrift) += p_.rate_noise * p_.rate_noise * dt;
    p(kRate, kRate) += p_.bias_walk * p_.bias_walk * dt;
    if (p(kDrift, kDrift) > kLost * kLost) forget(kDrift, kLost);
  }

  /// What the unit should read, turned to the axes the gyro takes for the world's: the field turned
  /// back by the drift, and the offset.
  UpdateStatus observe(const Eigen::Matrix3d& r, const Eigen::Vector3d& reading, double dt) {
    const double c = std::cos(x_[kDrift]), s = std::sin(x_[kDrift]);
    const Eigen::Vector3d h = x_.segment<3>(kField);
    const Eigen::Vector3d field(c * h.x() + s * h.y(), c * h.y() - s * h.x(), h.z());
    const Eigen::Vector3d off = r * (reading - offset_uT()) - field;
    const IndexedRow<double, 0, 2, 3, 5, 6, 7> east{{field.y(), c, s, r(0, 0), r(0, 1), r(0, 2)}};
    const IndexedRow<double, 0, 2, 3, 5, 6, 7> north{
        {-field.x(), -s, c, r(1, 0), r(1, 1), r(1, 2)}};
    const IndexedRow<double, 4, 5, 6, 7> up{{1.0, r(2, 0), r(2, 1), r(2, 2)}};
    if (foreign(east, off.x()) || foreign(north, off.y()) || foreign(up, off.z()))
      return refuse(dt);
    foreign_s_ = 0.0;
    // What is bent stays so for a while: as white noise it counts for more.
    const double density2 = 2.0 * p_.disturbance_uT * p_.disturbance_uT * p_.disturbance_s;
    Vector change = Vector::Zero();
    take(east, off.x(), density2 / dt, change);
    take(north, off.y(), density2 / dt, change);
    take(up, off.z(), density2 / dt, change);
    x_ += change;
    return UpdateStatus::used;
  }

  using Vector = Eigen::Matrix<double, kSize, 1>;

  template <int... Index>
  [[nodiscard]] bool foreign(const IndexedRow<double, Index...>& row, double off) const {
    const auto ph = covariance_.times(row);
    const double expected = std::max(row.sum([&](int i) { return ph[std::size_t(i)]; }), 0.0) +
                            p_.disturbance_uT * p_.disturbance_uT;
    return off * off > p_.gate_sigmas * p_.gate_sigmas * expected;
  }

  UpdateStatus refuse(double dt) {
    foreign_s_ += dt;
    if (foreign_s_ < p_.relearn_s) return UpdateStatus::disturbed;
    foreign_s_ = 0.0;
    forget_fields();
    return UpdateStatus::disturbed;
  }

  template <int... Index>
  void take(const IndexedRow<double, Index...>& row, double off, double variance, Vector& change) {
    const auto ph = covariance_.times(row);
    const double expected = std::max(row.sum([&](int i) { return ph[std::size_t(i)]; }), 0.0);
    const double weight = 1.0 / (expected + variance);
    const double rest = off - row.sum([&](int i) { return change[i]; });
    for (int i = 0; i < kSize; ++i) change[i] += ph[std::size_t(i)] * rest * weight;
    covariance_.subtract_outer(ph, weight);
    for (int i = 0; i < kSize; ++i)
      if (covariance_(i, i) < 0.0) covariance_.decouple(i, 0.0);
  }

  MagneticHeadingDriftParameters p_;
  Vector x_ = Vector::Zero();
  SymmetricMatrix<double, kSize> covariance_;
  SampleClock clock_{1.0};
  SensorReport report_;
  double since_s_ = 0.0, foreign_s_ = 0.0;
};

}  // namespace wayfare
