#include "slam/motion.hpp"

#include <algorithm>
#include <cmath>

namespace wayfare {

Motion MotionModel::predict(LogTime time, const std::optional<SE2d>& odometry) const {
  if (!last_) return {};
  if (odometry && last_->odometry) {
    const SE2d increment = last_->odometry->inverse() * *odometry;
    return {increment, sigma_of(increment, odometry_noise_)};
  }
  constexpr double kLongest_s = 0.5;  // no extrapolation through a gap in the log
  const double dt = std::min(to_seconds(time - last_->time), kLongest_s);
  const SE2d increment = SE2d::exp(velocity_ * dt);
  return {increment, sigma_of(increment, velocity_noise_)};
}

/// Timestamp jitter makes short intervals look fast: an interval much shorter than usual is
/// combined with the next one.
void MotionModel::update(LogTime time, const SE2d& pose, const std::optional<SE2d>& odometry) {
  constexpr double kLongest_s = 0.5, kGain = 0.1;
  if (last_) {
    const double step = std::min(to_seconds(time - last_->time), kLongest_s);
    mean_interval_s_ =
        mean_interval_s_ > 0.0 ? mean_interval_s_ + kGain * (step - mean_interval_s_) : step;
    const double dt = to_seconds(time - velocity_from_.time);
    if (dt > 0.0 && dt >= 0.5 * mean_interval_s_) {
      velocity_ = pose.minus(velocity_from_.pose) / dt;
      velocity_from_ = {time, pose};
    }
  } else {
    velocity_from_ = {time, pose};
  }
  last_ = {time, pose, odometry};
}

bool jumps(const Motion& odometry, const Motion& by_velocity) {
  constexpr double kLeap_m = 1.0;
  return (odometry.increment.translation() - by_velocity.increment.translation()).norm() > kLeap_m;
}

bool contradicts(const Motion& odometry, const Motion& by_velocity, double sigmas) {
  const Eigen::Vector3d d = odometry.increment.minus(by_velocity.increment);
  return (d.cwiseAbs().array() > sigmas * by_velocity.sigma.array()).any();
}

}  // namespace wayfare
