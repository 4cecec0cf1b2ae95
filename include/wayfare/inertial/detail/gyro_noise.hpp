#pragma once

#include <Eigen/Core>

#include <wayfare/inertial/ahrs_parameters.hpp>

namespace wayfare {

/// Growth of the attitude variance over one gyro reading.
template <class T>
class GyroNoise {
 public:
  using Vector = Eigen::Matrix<T, 3, 1>;

  explicit GyroNoise(const AhrsParameters& p)
      : rate2_(T(p.rate_noise * p.rate_noise)),
        scale2_(T(p.rate_scale_noise * p.rate_scale_noise)),
        walk2_(T(p.bias_walk * p.bias_walk)),
        saturated2_(T(p.saturated_part * p.saturated_part)) {}

  /// Variance gained about any axis over dt, rad², at mean rate `rate` after `last`. `coarse`: dt
  /// is too long to assume a constant rate.
  T angle_variance(const Vector& rate, const Vector& last, T dt, bool coarse, bool saturated) {
    const T square = rate.squaredNorm();
    T variance = (rate2_ + scale2_ * square) * dt;
    if (coarse) variance += T(0.25) * (rate - last).squaredNorm() * dt * dt;
    // The error of a saturated gyro is constant: its standard deviation grows linearly with time.
    const T before = saturated_s_;
    saturated_s_ = saturated ? saturated_s_ + dt : T(0);
    if (saturated)
      variance += saturated2_ * square * (saturated_s_ * saturated_s_ - before * before);
    return variance;
  }
  [[nodiscard]] T bias_variance(T dt) const { return walk2_ * dt; }

 private:
  T rate2_, scale2_, walk2_, saturated2_;
  T saturated_s_ = T(0);
};

}  // namespace wayfare
