#pragma once

#include <cmath>

#include <wayfare/core/gaussian.hpp>
#include <wayfare/core/se2.hpp>
#include <wayfare/slam/radar_slam.hpp>

namespace wayfare {

/// Motion since an update, with the time for which the gyro's bias acts on its heading.
struct BiasedMotion {
  Gaussian<SE2d> raw{SE2d(), Eigen::Matrix3d::Zero()};
  double gyro_s = 0.0;
};

[[nodiscard]] inline BiasedMotion compose(const BiasedMotion& a, const BiasedMotion& b) {
  return {compose(a.raw, b.raw), a.gyro_s + b.gyro_s};
}

/// As the particle expects it: without its bias, which had acted evenly along the motion.
[[nodiscard]] inline Gaussian<SE2d> without_bias(const BiasedMotion& motion, const GyroBias& bias) {
  const double turn = -bias.mean_rad_s * motion.gyro_s;
  Gaussian<SE2d> g = motion.raw;
  g.mean = SE2d(SO2d(Angle::radians(0.5 * turn)) * g.mean.translation(),
                SO2d(Angle::radians(turn)) * g.mean.rotation());
  g.covariance(2, 2) += bias.variance * motion.gyro_s * motion.gyro_s;
  return g;
}

/// Its decay to the stationary variance over an interval.
inline void predict(GyroBias& bias, const GyroBiasOptions& options, double interval_s) {
  const double decay = std::exp(-interval_s / options.correlation_time_s);
  const double stationary = options.sigma_rad_s * options.sigma_rad_s;
  bias.mean_rad_s *= decay;
  bias.variance = stationary + decay * decay * (bias.variance - stationary);
}

/// A Kalman update by the turn that the particle was given, of which the motion measured
/// turn + bias · time + noise. A turn beyond five standard deviations relocates the particle, and
/// says nothing of the bias.
inline void update(GyroBias& bias, const BiasedMotion& motion, Angle turned) {
  const double t = motion.gyro_s;
  const double innovation =
      (motion.raw.mean.rotation().angle() - turned).wrapped().radians() - bias.mean_rad_s * t;
  const double variance = bias.variance * t * t + motion.raw.covariance(2, 2);
  if (!(variance > 0.0) || innovation * innovation > 25.0 * variance) return;
  const double gain = bias.variance * t / variance;
  bias.mean_rad_s += gain * innovation;
  bias.variance *= 1.0 - gain * t;
}

}  // namespace wayfare
