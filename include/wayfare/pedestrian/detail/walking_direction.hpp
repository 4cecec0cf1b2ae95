#pragma once

// Walking direction relative to a sensor of unknown orientation on the body.

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <wayfare/core/angle.hpp>

namespace wayfare {

/// The body sways along the walking direction (Kourogi and Kurata 2003): the principal axis of the
/// horizontal acceleration, relative to the sensor's heading. Its sign is that of the forward
/// acceleration while the body rises. Coarse: a hand sways 15° off, so this is for arbitrary
/// mounting, as in a pocket.
class WalkingDirection {
 public:
  /// `memory_s`: averaging time, s of walking.
  explicit WalkingDirection(double memory_s = 20.0) : memory_s_(memory_s) {}

  /// Specific force in level world axes (z up) and the heading of the sensor's forward axis in
  /// them, counter-clockwise from x.
  void add(const Eigen::Vector3d& world_force, Angle sensor_heading, double dt) {
    if (!(dt > 0.0) || !world_force.allFinite()) return;
    constexpr double kLow_s = 0.23, kHigh_s = 0.053;  // 0.7 Hz and 3 Hz
    if (!started_) slow_ = world_force;
    started_ = true;
    slow_ += std::min(1.0, dt / kLow_s) * (world_force - slow_);
    const Eigen::Vector3d before = band_;
    band_ += std::min(1.0, dt / kHigh_s) * (world_force - slow_ - band_);
    const double rising = (band_.z() - before.z()) / dt;
    const Eigen::Vector2d sway = Eigen::Rotation2Dd(-sensor_heading.radians()) * band_.head<2>();
    const double part = std::min(1.0, dt / memory_s_);
    spread_ += part * (sway * sway.transpose() - spread_);
    drive_ += part * (rising * sway - drive_);
  }

  /// From the sensor's forward axis to the direction of walking, counter-clockwise.
  [[nodiscard]] Angle offset() const {
    const double angle = 0.5 * std::atan2(2.0 * spread_(0, 1), spread_(0, 0) - spread_(1, 1));
    const Eigen::Vector2d axis(std::cos(angle), std::sin(angle));
    return Angle::radians(axis.dot(drive_) < 0.0 ? angle + std::numbers::pi : angle).wrapped();
  }
  /// Ratio of the variances along and across the axis; one: undetermined.
  [[nodiscard]] double variance_ratio() const {
    const double half = 0.5 * spread_.trace();
    const double d = std::hypot(0.5 * (spread_(0, 0) - spread_(1, 1)), spread_(0, 1));
    return half - d > 0.0 ? (half + d) / (half - d) : 1.0;
  }

 private:
  double memory_s_;
  bool started_ = false;
  Eigen::Vector3d slow_ = Eigen::Vector3d::Zero(), band_ = Eigen::Vector3d::Zero();
  Eigen::Matrix2d spread_ = Eigen::Matrix2d::Zero();
  Eigen::Vector2d drive_ = Eigen::Vector2d::Zero();
};

}  // namespace wayfare
