#pragma once

// Gyro bias from the mean rate of a foot at rest.

#include <cmath>
#include <optional>

#include <Eigen/Core>

#include <wayfare/pedestrian/parameters.hpp>

namespace wayfare {

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
