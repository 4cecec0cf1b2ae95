#pragma once

// Process noise of the foot's strapdown navigation, and the gyro's bias from a foot at rest.

#include <algorithm>
#include <cmath>
#include <optional>

#include <Eigen/Core>

#include <wayfare/core/se3.hpp>
#include <wayfare/pedestrian/detail/foot_filter.hpp>
#include <wayfare/pedestrian/parameters.hpp>
#include <wayfare/sensors/measurements.hpp>

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

/// Means over a tenth of a second, after FootParameters::rest_time_s of rest. A standing person
/// sways slowly: the uncertainty grows with the rate's root mean square.
class FootRest {
 public:
  struct Bias {
    Eigen::Vector3d rate_radps;
    double sigma_radps;
  };

  explicit FootRest(const FootParameters& parameters) : p_(parameters) {}

  /// The mean, if this reading completes one.
  [[nodiscard]] std::optional<Bias> add(const Eigen::Vector3d& rate_radps, double statistic,
                                        double dt) {
    constexpr double kMean_s = 0.1;
    if (!(statistic < p_.rest_statistic)) {
      rest_s_ = sum_s_ = 0.0;
      return std::nullopt;
    }
    rest_s_ += dt;
    if (sum_s_ <= 0.0) {
      sum_.setZero();
      square_ = 0.0;
    }
    sum_ += rate_radps * dt;
    square_ += rate_radps.squaredNorm() * dt;
    sum_s_ += dt;
    if (sum_s_ < kMean_s) return std::nullopt;
    const Bias bias{sum_ / sum_s_, p_.rest_rate_part * std::sqrt(square_ / sum_s_)};
    sum_s_ = 0.0;
    return rest_s_ > p_.rest_time_s ? std::optional(bias) : std::nullopt;
  }
  /// Restarts the rest time.
  void interrupt() { rest_s_ = 0.0; }

 private:
  FootParameters p_;
  Eigen::Vector3d sum_ = Eigen::Vector3d::Zero();
  double rest_s_ = 0.0, sum_s_ = 0.0, square_ = 0.0;
};

}  // namespace wayfare
