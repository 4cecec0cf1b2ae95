#include "nav/gnss_ins/zero_velocity_detector.hpp"

#include <algorithm>

namespace wayfare::nav {

void ZeroVelocityDetector::learn(const RecentReadings& recent, double speed_mps) {
  if (speed_mps > 3.0)
    moving_spread_mps2_ += 0.05 * (recent.force_spread_mps2() - moving_spread_mps2_);
}

bool ZeroVelocityDetector::calm(const RecentReadings& recent, const Motion& motion) const {
  // Below a third of the vibration in motion, within limits; engines vibrate the gyros by some 0.2
  // rad/s per m/s².
  const double force = std::clamp(0.3 * moving_spread_mps2_, 0.15, 0.4);
  return recent.full() && recent.force_spread_mps2() < force &&
         recent.rate_spread_radps() < 0.2 * force &&
         (recent.mean_rate_radps() - motion.gyro_bias_radps).norm() < 0.015;
}

double ZeroVelocityDetector::speed_limit(const RecentReadings& recent, const Motion& motion) const {
  // A smooth ride resembles a stop. With a known vibration in motion, calm is accepted at less
  // certain velocities; else only at almost zero.
  const bool vibrates_in_motion = recent.force_spread_mps2() < 0.5 * moving_spread_mps2_;
  return vibrates_in_motion ? std::clamp(3.0 * motion.speed_sigma_mps, 0.3, 3.0) : 0.3;
}

bool ZeroVelocityDetector::update(LogTime now, const RecentReadings& recent, const Motion& motion) {
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

}  // namespace wayfare::nav
