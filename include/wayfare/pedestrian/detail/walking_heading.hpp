#pragma once

// Headings of a walk, the walking direction relative to the sensor, and the covariance of both.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <wayfare/core/angle.hpp>
#include <wayfare/core/time.hpp>
#include <wayfare/pedestrian/parameters.hpp>

namespace wayfare {

/// Moving average, since heads and hands turn to and fro.
class WalkingHeading {
 public:
  /// An averaged heading.
  struct Entry {
    LogTime time;           ///< of the last reading in it
    double radians = 0.0;   ///< not wrapped, averaged
    double variance = 0.0;  ///< of the average, rad²
  };

  /// Averages over `average_s`.
  explicit WalkingHeading(double average_s) : average_s_(average_s) {}

  /// `variance()` is called for the entries that are kept. Returns the time since the previous
  /// reading, s; zero for the first.
  template <class Variance>
  double add(LogTime time, double radians, const Variance& variance) {
    const double dt = started_ ? to_seconds(time - last_) : 0.0;
    if (!started_ || dt < 0.0 || dt > 1.0) {
      unwrapped_ = average_ = radians;
      count_ = 0;
    } else {
      unwrapped_ += wrap_to_pi(radians - unwrapped_);
      average_ += std::min(1.0, 2.0 * dt / average_s_) * (unwrapped_ - average_);
    }
    started_ = true;
    last_ = time;
    if (count_ == 0 || to_seconds(time - entry(0).time) >= kSpacing_s) store(time, variance());
    return dt;
  }

  /// Rotates the stored headings by a correction.
  void rotate(double radians) {
    unwrapped_ += radians;
    average_ += radians;
    for (Entry& e : entries_) e.radians += radians;
  }

  /// Latest heading, not averaged.
  [[nodiscard]] double now() const { return unwrapped_; }
  /// The latest entry not after `time`, or the oldest; null before the first.
  [[nodiscard]] const Entry* at(LogTime time) const {
    for (std::size_t age = 0; age < count_; ++age)
      if (entry(age).time <= time) return &entry(age);
    return count_ > 0 ? &entry(count_ - 1) : nullptr;
  }

 private:
  static constexpr std::size_t kEntries = 1024;
  static constexpr double kSpacing_s = 0.02;

  void store(LogTime time, double variance) {
    newest_ = (newest_ + 1) % kEntries;
    entries_[newest_] = {time, average_, variance};
    count_ = std::min(count_ + 1, kEntries);
  }
  [[nodiscard]] const Entry& entry(std::size_t age) const {
    return entries_[(newest_ + kEntries - age) % kEntries];
  }

  double average_s_;
  std::array<Entry, kEntries> entries_;
  std::size_t newest_ = 0, count_ = 0;
  LogTime last_;
  double unwrapped_ = 0.0, average_ = 0.0;
  bool started_ = false;
};

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

/// Covariance of a dead-reckoned pose. Independent errors of the steps accumulate as a random walk;
/// common ones scale and rotate the whole path about its start.
class WalkCovariance {
 public:
  template <class Length>
  /// Without steps.
  explicit WalkCovariance(const BasicPedestrianParameters<Length>& p)
      : length2_(square(p.length_sigma)),
        scale2_(square(p.length_scale_sigma)),
        direction2_(square(p.direction_sigma)),
        offset2_(square(p.direction_offset_sigma)) {}

  /// Covariance of x, y and heading after a step of `length` along a unit vector, at `from_start`.
  [[nodiscard]] Eigen::Matrix3d step(double length, const Eigen::Vector2d& along,
                                     const Eigen::Vector2d& from_start, double heading_variance) {
    const Eigen::Vector2d across(-along.y(), along.x());
    independent_ += square(length) * (length2_ * along * along.transpose() +
                                      direction2_ * across * across.transpose());
    const Eigen::Vector2d sideways(-from_start.y(), from_start.x());
    const double common = offset2_ + heading_variance;
    Eigen::Matrix3d p;
    p.topLeftCorner<2, 2>() = independent_ + scale2_ * from_start * from_start.transpose() +
                              common * sideways * sideways.transpose();
    p.topRightCorner<2, 1>() = common * sideways;
    p.bottomLeftCorner<1, 2>() = common * sideways.transpose();
    p(2, 2) = common + direction2_;
    return p;
  }

 private:
  static double square(double x) { return x * x; }

  double length2_, scale2_, direction2_, offset2_;
  Eigen::Matrix2d independent_ = Eigen::Matrix2d::Zero();
};

}  // namespace wayfare
