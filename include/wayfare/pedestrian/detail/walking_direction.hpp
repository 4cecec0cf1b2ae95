#pragma once

// Which way a body walks, by a sensor on it that points another way.

#include <algorithm>
#include <cmath>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <wayfare/core/angle.hpp>

namespace wayfare {

/// The axis along which the body sways while it walks is the one it walks along (Kourogi and Kurata
/// 2003): the principal axis of the horizontal acceleration, seen from the sensor's heading. Of the
/// two directions along it, the one in which the body is driven forward as it rises. Coarse: a hand
/// sways 15° askew, so this serves where a sensor may sit any way round, as in a pocket.
class WalkingDirection {
 public:
  /// The mean is taken over so long, s, of walking.
  explicit WalkingDirection(double memory_s = 20.0) : memory_s_(memory_s) {}

  /// Specific force in a level world (z up) and where the sensor's forward axis points in it,
  /// counter-clockwise from x.
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
    return Angle::radians(axis.dot(drive_) < 0.0 ? angle + 3.14159265358979324 : angle).wrapped();
  }
  /// How much more the body sways along the axis than across: variances' ratio; one says nothing.
  [[nodiscard]] double clearness() const {
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
