#pragma once

#include <algorithm>
#include <cmath>
#include <optional>

#include <Eigen/Core>

#include <wayfare/core/time.hpp>
#include <wayfare/sensors/measurements.hpp>

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

/// Detects standstill of a vehicle from inertial readings. Learns the vibration level in motion,
/// since an idling engine in one car vibrates as much as a smooth ride in another.
class ZeroVelocityDetector {
 public:
  struct Motion {
    Eigen::Vector3d gyro_bias_radps;
    double speed_mps, speed_sigma_mps;
  };

  /// To call while the speed is known from satellites.
  void learn(const RecentReadings& recent, double speed_mps) {
    if (speed_mps > 3.0)
      moving_spread_mps2_ += 0.05 * (recent.force_spread_mps2() - moving_spread_mps2_);
  }

  /// True after half a second of standstill.
  [[nodiscard]] bool update(LogTime now, const RecentReadings& recent, const Motion& motion) {
    // A gentle start causes neither vibration nor rotation, but changes the mean force.
    const bool force_changed = since_ && (recent.mean_force_mps2() - force_mps2_).norm() > 0.08;
    if (force_changed || !calm(recent, motion) || motion.speed_mps > speed_limit(recent, motion)) {
      since_.reset();
      return false;
    }
    if (!since_) {
      since_ = now;
      force_mps2_ = recent.mean_force_mps2();
    }
    return to_seconds(now - *since_) >= 0.5;
  }
  void forget() { since_.reset(); }

 private:
  [[nodiscard]] bool calm(const RecentReadings& recent, const Motion& motion) const {
    // Below a third of the vibration in motion, within limits; engines vibrate the gyros by some
    // 0.2 rad/s per m/s².
    const double force = std::clamp(0.3 * moving_spread_mps2_, 0.15, 0.4);
    return recent.full() && recent.force_spread_mps2() < force &&
           recent.rate_spread_radps() < 0.2 * force &&
           (recent.mean_rate_radps() - motion.gyro_bias_radps).norm() < 0.015;
  }

  [[nodiscard]] double speed_limit(const RecentReadings& recent, const Motion& motion) const {
    // A smooth ride resembles a stop. With a known vibration in motion, calm is accepted at less
    // certain velocities; else only at almost zero.
    const bool vibrates_in_motion = recent.force_spread_mps2() < 0.5 * moving_spread_mps2_;
    return vibrates_in_motion ? std::clamp(3.0 * motion.speed_sigma_mps, 0.3, 3.0) : 0.3;
  }

  double moving_spread_mps2_ = 0.0;  ///< of the accelerometers in motion; zero: unknown
  std::optional<LogTime> since_;
  Eigen::Vector3d force_mps2_ = Eigen::Vector3d::Zero();  ///< at the start of the standstill
};

}  // namespace wayfare::nav
