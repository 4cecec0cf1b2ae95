#pragma once

// The mean turn rate of a foot at rest, which is the gyro's bias.

#include <optional>

#include <Eigen/Core>

#include <wayfare/estimate/foot_parameters.hpp>

namespace wayfare {

/// Means over a tenth of a second, once the foot has rested for FootParameters::rest_time_s.
class FootRest {
 public:
  explicit FootRest(const FootParameters& parameters) : p_(parameters) {}

  /// The mean, where one is complete with this reading.
  [[nodiscard]] std::optional<Eigen::Vector3d> add(const Eigen::Vector3d& rate_radps,
                                                   double statistic, double dt) {
    constexpr double kMean_s = 0.1;
    if (!(statistic < p_.rest_statistic)) {
      rest_s_ = sum_s_ = 0.0;
      return std::nullopt;
    }
    rest_s_ += dt;
    if (sum_s_ <= 0.0) sum_.setZero();
    sum_ += rate_radps * dt;
    sum_s_ += dt;
    if (sum_s_ < kMean_s) return std::nullopt;
    const Eigen::Vector3d mean = sum_ / sum_s_;
    sum_s_ = 0.0;
    return rest_s_ > p_.rest_time_s ? std::optional(mean) : std::nullopt;
  }
  /// Rest begins anew.
  void interrupt() { rest_s_ = 0.0; }

 private:
  FootParameters p_;
  Eigen::Vector3d sum_ = Eigen::Vector3d::Zero();
  double rest_s_ = 0.0, sum_s_ = 0.0;
};

}  // namespace wayfare
