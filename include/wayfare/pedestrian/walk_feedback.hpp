#pragma once

// Step scale and walking direction from map matching.

#include <algorithm>
#include <cmath>
#include <deque>

#include <Eigen/Core>

#include <wayfare/core/angle.hpp>
#include <wayfare/core/time.hpp>

namespace wayfare {

struct WalkFeedbackParameters {
  double scale_sigma = 0.06;  ///< prior, of the logarithm of the step scale
  double direction_sigma =
      0.3;  ///< prior, of the walking direction relative to the unit's axis, rad
  /// Random walk of the direction, rad/√s: the wearer looks around.
  double direction_wander = 0.15;
  double window_m = 1.5;        ///< distance over which map and steps are compared
  double sigma_m = 0.06;        ///< of the map's displacement over this distance
  double scale_wander = 0.002;  ///< of the logarithm, over this distance
};

/// Two scalar Kalman filters: the logarithm of the step scale and the angle from the steps'
/// direction to the direction of motion.
class WalkFeedback {
 public:
  explicit WalkFeedback(const WalkFeedbackParameters& p = {})
      : p_(p),
        scale_variance_(p.scale_sigma * p.scale_sigma),
        direction_variance_(p.direction_sigma * p.direction_sigma) {}

  [[nodiscard]] double scale() const { return std::exp(log_scale_); }
  [[nodiscard]] Angle direction() const { return Angle::radians(direction_); }

  /// At each scan: position by the map and by the uncorrected steps, in frames with the same
  /// heading; `length_known`: whether the scene constrains the motion along the path.
  void add(LogTime time, const Eigen::Vector2d& by_map_m, const Eigen::Vector2d& by_steps_m,
           bool length_known) {
    if (!past_.empty()) {
      const double dt = std::clamp(to_seconds(time - past_.back().time), 0.0, 5.0);
      direction_variance_ += p_.direction_wander * p_.direction_wander * dt;
    }
    past_.push_back({time, by_map_m, by_steps_m, length_known});
    const Past& first = past_.front();
    const Eigen::Vector2d map = by_map_m - first.by_map_m, steps = by_steps_m - first.by_steps_m;
    if (!(steps.norm() >= p_.window_m)) {
      if (past_.size() > kMaxScans) past_.pop_front();
      return;
    }
    const double length = std::max(map.norm(), 0.3);
    if (map.norm() > 0.3 * steps.norm())
      fuse(direction_, direction_variance_, angle(steps, map), p_.sigma_m / length);
    const bool known =
        std::all_of(past_.begin(), past_.end(), [](const Past& p) { return p.length_known; });
    if (known && map.norm() > 0.5 * steps.norm() && map.norm() < 2.0 * steps.norm()) {
      scale_variance_ += p_.scale_wander * p_.scale_wander;
      fuse(log_scale_, scale_variance_, std::log(map.norm() / steps.norm()),
           2.0 * p_.sigma_m / length);
    }
    past_.erase(past_.begin(), past_.end() - 1);
  }

 private:
  static constexpr std::size_t kMaxScans = 400;
  struct Past {
    LogTime time;
    Eigen::Vector2d by_map_m, by_steps_m;
    bool length_known;
  };

  static double angle(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
    return std::atan2(a.x() * b.y() - a.y() * b.x(), a.dot(b));
  }
  static void fuse(double& value, double& variance, double measured, double sigma) {
    const double gain = variance / (variance + sigma * sigma);
    value += gain * (measured - value);
    variance *= 1.0 - gain;
  }

  WalkFeedbackParameters p_;
  double log_scale_ = 0.0, scale_variance_;
  double direction_ = 0.0, direction_variance_;
  std::deque<Past> past_;
};

}  // namespace wayfare
