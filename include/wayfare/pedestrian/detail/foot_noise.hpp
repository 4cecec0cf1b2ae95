#pragma once

// Process noise of the foot's strapdown navigation.

#include <algorithm>
#include <cmath>

#include <Eigen/Core>

#include <wayfare/core/so3.hpp>
#include <wayfare/pedestrian/detail/foot_filter.hpp>
#include <wayfare/pedestrian/parameters.hpp>
#include <wayfare/sensors/imu.hpp>

namespace wayfare {

/// Grows with motion, with the difference between readings (undersampled impacts) and with
/// saturation.
class FootNoise {
 public:
  using Vector = Eigen::Vector3d;

  explicit FootNoise(const FootParameters& parameters) : p_(parameters) {}

  /// Noise of the step of `dt` seconds from `last` to `now` in attitude `q`.
  [[nodiscard]] FootFilter::Noise operator()(const ImuSample& last, const ImuSample& now,
                                             const SO3d& q, double dt) {
    const Vector& w = now.angular_rate_radps;
    const Vector& f = now.specific_force_mps2;
    const double a = f.norm() - p_.gravity_mps2;
    FootFilter::Noise n;
    n.velocity = (square(p_.force_noise) + square(p_.force_scale_noise * a)) * dt +
                 square(p_.force_jump_noise * dt) * (f - last.specific_force_mps2).squaredNorm();
    if (f.cwiseAbs().maxCoeff() >= p_.force_range)
      n.velocity += square(p_.saturated_part * p_.force_range * dt);
    n.angle = (square(p_.rate_noise) + square(p_.rate_scale_noise) * w.squaredNorm()) * dt +
              square(p_.rate_jump_noise * dt) * (w - last.angular_rate_radps).squaredNorm();
    n.rate_bias = square(p_.rate_bias_walk) * dt;
    n.force_bias = square(p_.force_bias_walk) * dt;
    n.missed_turn = missed_turn(w, q, dt);
    return n;
  }

  /// Noise of a gap without readings.
  [[nodiscard]] static FootFilter::Noise pause(double gap_s, double speed_mps) {
    constexpr double kRate_radps = 1.0;
    FootFilter::Noise n;
    n.position = square(speed_mps * gap_s);
    n.angle = square(std::min(kRate_radps * gap_s, 1.0));
    return n;
  }

 private:
  static double square(double x) { return x * x; }

  /// The error of a saturated axis is constant: its standard deviation grows linearly with time.
  [[nodiscard]] Eigen::Matrix3d missed_turn(const Vector& w, const SO3d& q, double dt) {
    Vector missed = Vector::Zero();
    for (int i = 0; i < 3; ++i)
      if (std::abs(w[i]) >= p_.rate_range) missed[i] = p_.saturated_part * w[i] * dt;
    if (missed.isZero(0.0)) {
      missed_.setZero();
      return Eigen::Matrix3d::Zero();
    }
    const Vector now = q * missed;
    const double before = missed_.norm();
    missed_ += now;
    // (b + n)² − b² along n.
    return (1.0 + 2.0 * before / now.norm()) * now * now.transpose();
  }

  FootParameters p_;
  Vector missed_ = Vector::Zero();
};

}  // namespace wayfare
