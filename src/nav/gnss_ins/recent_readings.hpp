#pragma once

#include <cmath>

#include <Eigen/Core>

#include <wayfare/sensors/imu.hpp>

namespace wayfare::nav {

/// Exponential mean and deviation of about the last second of readings.
class RecentReadings {
 public:
  void add(const ImuSample& s, double dt_s) {
    const double decay = std::exp(-dt_s / kMemory_s), gain = 1.0 - decay;
    if (seen_s_ > 0.0) {
      const Eigen::Vector3d step = s.angular_rate_radps - newest_rate_;
      vibration_ += gain * (0.5 * step.cwiseAbs2() - vibration_);
    }
    newest_rate_ = s.angular_rate_radps;
    seen_s_ += dt_s;
    blend(s.angular_rate_radps, decay, gain, rate_, rate_variance_);
    blend(s.specific_force_mps2, decay, gain, force_, force_variance_);
  }
  void forget() { *this = RecentReadings(); }

  [[nodiscard]] bool full() const { return seen_s_ > 2.0 * kMemory_s; }
  [[nodiscard]] const Eigen::Vector3d& mean_rate_radps() const { return rate_; }
  [[nodiscard]] const Eigen::Vector3d& mean_force_mps2() const { return force_; }
  /// Of the three axes together.
  [[nodiscard]] double rate_spread_radps() const { return std::sqrt(rate_variance_); }
  [[nodiscard]] double force_spread_mps2() const { return std::sqrt(force_variance_); }
  /// Sample-to-sample variance of each gyro, (rad/s)²: noise and vibration without the vehicle's
  /// rotation.
  [[nodiscard]] const Eigen::Vector3d& vibration_radps2() const { return vibration_; }

 private:
  static constexpr double kMemory_s = 0.5;

  void blend(const Eigen::Vector3d& x, double decay, double gain, Eigen::Vector3d& mean,
             double& variance) const {
    if (seen_s_ == 0.0) mean = x;
    const Eigen::Vector3d d = x - mean;
    mean += gain * d;
    variance = decay * (variance + gain * d.squaredNorm());
  }

  double seen_s_ = 0.0;
  Eigen::Vector3d rate_ = Eigen::Vector3d::Zero(), force_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d newest_rate_ = Eigen::Vector3d::Zero(), vibration_ = Eigen::Vector3d::Zero();
  double rate_variance_ = 0.0, force_variance_ = 0.0;
};

}  // namespace wayfare::nav
