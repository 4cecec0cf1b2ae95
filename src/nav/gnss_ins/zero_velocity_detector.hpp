#pragma once

#include <optional>

#include <Eigen/Core>

#include <wayfare/core/time.hpp>

#include "nav/gnss_ins/recent_readings.hpp"

namespace wayfare::nav {

/// Tells from an inertial unit whether its vehicle stands. How much it is shaken under way is
/// learnt, since an engine idling in one car shakes as much as a smooth ride in another.
class ZeroVelocityDetector {
 public:
  struct Motion {
    Eigen::Vector3d gyro_bias_radps;
    double speed_mps, speed_sigma_mps;
  };

  /// While satellites tell the speed.
  void learn(const RecentReadings& recent, double speed_mps);
  /// True where it has stood for half a second.
  [[nodiscard]] bool update(LogTime now, const RecentReadings& recent, const Motion& motion);
  void forget() { since_.reset(); }

 private:
  [[nodiscard]] bool calm(const RecentReadings& recent, const Motion& motion) const;
  [[nodiscard]] double speed_limit(const RecentReadings& recent, const Motion& motion) const;

  double moving_spread_mps2_ = 0.0;  ///< of the accelerometers under way; zero: not known
  std::optional<LogTime> since_;
  Eigen::Vector3d force_mps2_ = Eigen::Vector3d::Zero();  ///< felt when standing began
};

}  // namespace wayfare::nav
