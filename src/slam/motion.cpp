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
  constexpr double kLongest_s = 0.5;  // nobody coasts through a gap in the log
  const double dt = std::min(to_seconds(time - last_->time), kLongest_s);
  const SE2d increment = SE2d::exp(velocity_ * dt);
  return {increment, sigma_of(increment, velocity_noise_)};
}

/// Stamps that jitter make short steps look fast: one much shorter than usual is measured together
/// with the next.
void MotionModel::tell(LogTime time, const SE2d& pose, const std::optional<SE2d>& odometry) {
  constexpr double kLongest_s = 0.5, kNews = 0.1;
  if (last_) {
    const double step = std::min(to_seconds(time - last_->time), kLongest_s);
    usual_s_ = usual_s_ > 0.0 ? usual_s_ + kNews * (step - usual_s_) : step;
    const double dt = to_seconds(time - from_.time);
    if (dt > 0.0 && dt >= 0.5 * usual_s_) {
      velocity_ = pose.minus(from_.pose) / dt;
      from_ = {time, pose};
    }
  } else {
    from_ = {time, pose};
  }
  last_ = {time, pose, odometry};
}

bool leaps(const Motion& odometry, const Motion& going_on) {
  constexpr double kLeap_m = 1.0;
  return (odometry.increment.translation() - going_on.increment.translation()).norm() > kLeap_m;
}

bool contradicts(const Motion& odometry, const Motion& going_on, double sigmas) {
  const Eigen::Vector3d d = odometry.increment.minus(going_on.increment);
  return (d.cwiseAbs().array() > sigmas * going_on.sigma.array()).any();
}

}  // namespace wayfare
