#include "motion.hpp"

#include <algorithm>
#include <cmath>

namespace wayfare {

Motion MotionModel::predict(LogTime time, const std::optional<SE2d>& odometry) const {
  if (!last_) return {};
  if (odometry && last_->odometry) {
    const SE2d increment = last_->odometry->inverse() * *odometry;
    return {increment, sigma_of(increment, odometry_noise_)};
  }
  constexpr double kLongest_s = 0.5;  // nobody coasts through a gap in the log
  const double dt = std::min(to_seconds(time - last_->time), kLongest_s);
  const SE2d increment = SE2d::exp(velocity_ * dt);
  return {increment, sigma_of(increment, velocity_noise_)};
}

void MotionModel::tell(LogTime time, const SE2d& pose, const std::optional<SE2d>& odometry) {
  if (last_) {
    const double dt = to_seconds(time - last_->time);
    if (dt > 0.0) velocity_ = pose.minus(last_->pose) / dt;
  }
  last_ = {time, pose, odometry};
}

}  // namespace wayfare
