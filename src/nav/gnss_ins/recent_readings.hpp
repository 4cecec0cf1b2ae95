#pragma once

#include <cmath>

#include <Eigen/Core>

#include <wayfare/sensors/imu.hpp>

namespace wayfare::nav {

/// Mean and spread of the newest second or so of a unit's readings, fading exponentially.
class RecentReadings {
 public:
  void add(const ImuSample& s, double dt_s) {
    const double keep = std::exp(-dt_s / kMemory_s), take = 1.0 - keep;
    if (seen_s_ > 0.0) {
      const Eigen::Vector3d step = s.angular_rate_radps - newest_rate_;
      vibration_ += take * (0.5 * step.cwiseAbs2() - vibration_);
    }
    newest_rate_ = s.angular_rate_radps;
    seen_s_ += dt_s;
    blend(s.angular_rate_radps, keep, take, rate_, rate_variance_);
    blend(s.specific_force_mps2, keep, take, force_, force_variance_);
  }
  void forget() { *this = RecentReadings(); }

  [[nodiscard]] bool full() const { return seen_s_ > 2.0 * kMemory_s; }
  [[nodiscard]] const Eigen::Vector3d& mean_rate_radps() const { return rate_; }
  [[nodiscard]] const Eigen::Vector3d& mean_force_mps2() const { return force_; }
  /// Of the three axes together.
  [[nodiscard]] double rate_spread_radps() const { return std::sqrt(rate_variance_); }
  [[nodiscard]] double force_spread_mps2() const { return std::sqrt(force_variance_); }
  /// Variance of each gyro from one reading to the next, (rad/s)²: noise and vibration without
  /// the vehicle's turns.
  [[nodiscard]] const Eigen::Vector3d& shake_radps2() const { return vibration_; }

 private:
  static constexpr double kMemory_s = 0.5;

  void blend(const Eigen::Vector3d& x, double keep, double take, Eigen::Vector3d& mean,
             double& variance) const {
    if (seen_s_ == 0.0) mean = x;
    const Eigen::Vector3d d = x - mean;
    mean += take * d;
    variance = keep * (variance + take * d.squaredNorm());
  }

  double seen_s_ = 0.0;
  Eigen::Vector3d rate_ = Eigen::Vector3d::Zero(), force_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d newest_rate_ = Eigen::Vector3d::Zero(), vibration_ = Eigen::Vector3d::Zero();
  double rate_variance_ = 0.0, force_variance_ = 0.0;
};

}  // namespace wayfare::nav
