#pragma once

#include <optional>

#include <Eigen/Core>

#include <wayfare/core/time.hpp>

#include "nav/gnss_ins/recent_readings.hpp"

namespace wayfare::nav {

/// Detects standstill of a vehicle from inertial readings. Learns the vibration level in motion,
/// since an idling engine in one car vibrates as much as a smooth ride in another.
class ZeroVelocityDetector {
 public:
  struct Motion {
    Eigen::Vector3d gyro_bias_radps;
    double speed_mps, speed_sigma_mps;
  };

  /// To call while the speed is known from satellites.
  void learn(const RecentReadings& recent, double speed_mps);
  /// True after half a second of standstill.
  [[nodiscard]] bool update(LogTime now, const RecentReadings& recent, const Motion& motion);
  void forget() { since_.reset(); }

 private:
  [[nodiscard]] bool calm(const RecentReadings& recent, const Motion& motion) const;
  [[nodiscard]] double speed_limit(const RecentReadings& recent, const Motion& motion) const;

  double moving_spread_mps2_ = 0.0;  ///< of the accelerometers in motion; zero: unknown
  std::optional<LogTime> since_;
  Eigen::Vector3d force_mps2_ = Eigen::Vector3d::Zero();  ///< at the start of the standstill
};

}  // namespace wayfare::nav
