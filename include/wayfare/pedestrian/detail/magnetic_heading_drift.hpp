#pragma once

// Drift of a gyro heading from an uncalibrated magnetometer: the hard-iron field rotates with the
// unit, the Earth's does not.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>

#include <Eigen/Core>

#include <wayfare/core/se3.hpp>
#include <wayfare/filter/sequential_update.hpp>
#include <wayfare/inertial/attitude.hpp>
#include <wayfare/inertial/detail/sample_clock.hpp>

namespace wayfare {

/// Disabled if the offset is zero.
struct MagneticHeadingDriftParameters {
  /// Prior standard deviation of the magnetometer's offset per axis, µT.
  double offset_sigma_uT = 0.0;
  /// Prior standard deviation of the Earth's field per axis, µT.
  double field_sigma_uT = 60.0;
  /// Magnetic disturbances along the path: standard deviation, µT, and correlation time, s.
  double disturbance_uT = 4.0;
  double disturbance_s = 2.0;  ///< their correlation time
  /// Gate in standard deviations; a field rejected for this long, s, is learned as the new one.
  double gate_sigmas = 5.0;
  double relearn_s = 20.0;  ///< before a rejected field is learned
  /// Initial gyro bias about the vertical, rad/s, its random walk, rad/s/√s, and noise, rad/s/√Hz.
  double bias_sigma = 0.3 * kDegree;
  double bias_walk = 0.002 * kDegree;  ///< of the gyro bias, rad/s/√s
  double rate_noise = 0.1 * kDegree;   ///< of the rate, rad/s/√Hz
  double spacing_s = 0.1;              ///< between readings used

 private:
  static constexpr double kDegree = std::numbers::pi / 180.0;
};

/// An extended Kalman filter of eight states: heading drift and its rate, the Earth's field in
/// world axes, the offset in the unit's axes. World axes follow the gyro's initial heading, where
/// the drift is zero, so that a slow separation of offset and field does not affect the heading.
/// The separation needs turns: after minutes of straight walking the variances are too small.
class MagneticHeadingDrift {
 public:
  /// Without readings.
  explicit MagneticHeadingDrift(const MagneticHeadingDriftParameters& p) : p_(p) {
    forget(kDrift, 0.0);
    forget(kRate, p.bias_sigma);
    forget_fields();
  }

  /// Whether an offset is estimated.
  [[nodiscard]] bool on() const { return p_.offset_sigma_uT > 0.0; }

  /// A reading in the unit's axes, µT, or NaN, and the attitude from gyro and accelerometer alone,
  /// world z up.
  UpdateStatus add(LogTime time, const SO3d& q_world_body, const Eigen::Vector3d& field_uT) {
    const auto verdict = clock_.check(time);
    if (verdict == SampleClock::Verdict::late) return report_.note(UpdateStatus::late);
    const double step = verdict == SampleClock::Verdict::first ? 0.0 : clock_.step_s();
    if (step > kMaxGap_s) forget(kDrift, kLost);
    since_s_ += step;
    if (!field_uT.allFinite()) return report_.note(UpdateStatus::missing);
    if (since_s_ < p_.spacing_s) return report_.note(UpdateStatus::waiting);
    const double dt = since_s_;
    since_s_ = 0.0;
    propagate(dt);
    return report_.note(observe(q_world_body.matrix(), field_uT, std::min(dt, kMaxGap_s)));
  }

  /// Correction to add to the gyro heading, counter-clockwise, rad, and its variance.
  [[nodiscard]] double correction() const { return x_[kDrift]; }
  /// Of the correction, rad².
  [[nodiscard]] double variance() const { return covariance_(kDrift, kDrift); }
  /// Rate of the correction, rad/s.
  [[nodiscard]] double rate_radps() const { return x_[kRate]; }
  /// Of the magnetometer, µT, the unit's axes.
  [[nodiscard]] Eigen::Vector3d offset_uT() const { return x_.tail<3>(); }
  /// Standard deviation of the offset, µT.
  [[nodiscard]] Eigen::Vector3d offset_sigma_uT() const {
    const auto& p = covariance_;
    return Eigen::Vector3d(p(5, 5), p(6, 6), p(7, 7)).cwiseMax(0.0).cwiseSqrt();
  }
  /// Readings by status.
  [[nodiscard]] const SensorReport& report() const { return report_; }

 private:
  static constexpr int kDrift = 0, kRate = 1, kField = 2, kOffset = 5, kSize = 8;
  static constexpr double kMaxGap_s = 1.0;  ///< longest gap bridged by the gyro
  static constexpr double kLost = 1.0;      ///< rad, standard deviation of an unknown drift

  void forget(int i, double sigma) { covariance_.decouple(i, sigma * sigma); }
  void forget_fields() {
    for (int i = 0; i < 3; ++i) {
      forget(kField + i, p_.field_sigma_uT);
      forget(kOffset + i, p_.offset_sigma_uT);
    }
  }

  void propagate(double dt) {
    auto& p = covariance_;
    x_[kDrift] += x_[kRate] * dt;
    const double shared = p(kDrift, kRate);
    p(kDrift, kDrift) += dt * (2.0 * shared + dt * p(kRate, kRate));
    for (int j = kRate; j < kSize; ++j) p(kDrift, j) += dt * p(kRate, j);
    p(kDrift, kDrift) += p_.rate_noise * p_.rate_noise * dt;
    p(kRate, kRate) += p_.bias_walk * p_.bias_walk * dt;
    if (p(kDrift, kDrift) > kLost * kLost) forget(kDrift, kLost);
  }

  /// Compares the reading less the offset, in the gyro's world axes, with the field rotated back by
  /// the drift.
  UpdateStatus observe(const Eigen::Matrix3d& r, const Eigen::Vector3d& reading, double dt) {
    const double c = std::cos(x_[kDrift]), s = std::sin(x_[kDrift]);
    const Eigen::Vector3d h = x_.segment<3>(kField);
    const Eigen::Vector3d field(c * h.x() + s * h.y(), c * h.y() - s * h.x(), h.z());
    const Eigen::Vector3d off = r * (reading - offset_uT()) - field;
    const IndexedRow<double, 0, 2, 3, 5, 6, 7> east{{field.y(), c, s, r(0, 0), r(0, 1), r(0, 2)}};
    const IndexedRow<double, 0, 2, 3, 5, 6, 7> north{
        {-field.x(), -s, c, r(1, 0), r(1, 1), r(1, 2)}};
    const IndexedRow<double, 4, 5, 6, 7> up{{1.0, r(2, 0), r(2, 1), r(2, 2)}};
    if (disturbed(east, off.x()) || disturbed(north, off.y()) || disturbed(up, off.z()))
      return reject(dt);
    disturbed_s_ = 0.0;
    // Correlated disturbances as equivalent white noise.
    const double density2 = 2.0 * p_.disturbance_uT * p_.disturbance_uT * p_.disturbance_s;
    Vector change = Vector::Zero();
    update(east, off.x(), density2 / dt, change);
    update(north, off.y(), density2 / dt, change);
    update(up, off.z(), density2 / dt, change);
    x_ += change;
    return UpdateStatus::used;
  }

  using Vector = Eigen::Matrix<double, kSize, 1>;

  template <int... Index>
  [[nodiscard]] bool disturbed(const IndexedRow<double, Index...>& row, double off) const {
    const double expected = std::max(expected_innovation(covariance_, row).variance, 0.0) +
                            p_.disturbance_uT * p_.disturbance_uT;
    return off * off > p_.gate_sigmas * p_.gate_sigmas * expected;
  }

  UpdateStatus reject(double dt) {
    disturbed_s_ += dt;
    if (disturbed_s_ < p_.relearn_s) return UpdateStatus::disturbed;
    disturbed_s_ = 0.0;
    forget_fields();
    return UpdateStatus::disturbed;
  }

  template <int... Index>
  void update(const IndexedRow<double, Index...>& row, double off, double variance,
              Vector& change) {
    sequential_update(
        covariance_, change, row, expected_innovation(covariance_, row), off, variance,
        [](double cross, double left, double weight) { return cross * left * weight; });
    for (int i = 0; i < kSize; ++i)
      if (covariance_(i, i) < 0.0) covariance_.decouple(i, 0.0);
  }

  MagneticHeadingDriftParameters p_;
  Vector x_ = Vector::Zero();
  SymmetricMatrix<double, kSize> covariance_;
  SampleClock clock_{1.0};
  SensorReport report_;
  double since_s_ = 0.0, disturbed_s_ = 0.0;
};

}  // namespace wayfare
