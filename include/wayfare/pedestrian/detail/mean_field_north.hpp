#pragma once

// Magnetic north by the mean field along a walk.

#include <algorithm>
#include <cmath>
#include <optional>

#include <Eigen/Core>

#include <wayfare/core/angle.hpp>
#include <wayfare/core/se3.hpp>
#include <wayfare/core/time.hpp>
#include <wayfare/inertial/attitude.hpp>

namespace wayfare {

/// Whether north is from the mean field, and the field's errors.
struct MeanFieldNorthParameters {
  bool on = false;  ///< used
  /// Error of the field's direction inside buildings: standard deviation, rad, and the time of
  /// walking, s, over which it is the same.
  double sigma_rad = 0.35;
  double correlation_s = 20.0;  ///< of walking over which the error is the same
};

/// The horizontal field in the axes of an attitude by the gyro alone, averaged over the steps: its
/// direction is magnetic north. Disturbances inside buildings, which bend a causal heading one
/// after the other, average out over the path; the gyro's drift over the walk must be small.
class MeanFieldNorth {
 public:
  /// The declination of magnetic from true north, clockwise; zero gives magnetic headings.
  explicit MeanFieldNorth(const MeanFieldNorthParameters& parameters = {}, Angle declination = {})
      : p_(parameters), declination_(declination) {}

  /// Whether it is used.
  [[nodiscard]] bool on() const { return p_.on; }

  /// A field in the unit's axes, µT, and the attitude by the gyro alone.
  UpdateStatus add(LogTime time, const SO3d& q_world_body, const Eigen::Vector3d& field_uT) {
    constexpr double kAverage_s = 0.5;
    if (!field_uT.allFinite() || !(field_uT.norm() > 0.0))
      return report_.note(UpdateStatus::missing);
    if (last_ && time <= *last_) return report_.note(UpdateStatus::late);
    const Eigen::Vector2d level = (q_world_body * field_uT).head<2>();
    const double part = last_ ? std::min(1.0, to_seconds(time - *last_) / kAverage_s) : 1.0;
    recent_uT_ += part * (level - recent_uT_);
    last_ = time;
    return report_.note(UpdateStatus::used);
  }
  /// At each step: standing does not count, since it is all at one place.
  void step(double interval_s) {
    if (!last_) return;
    sum_ += interval_s * recent_uT_;
    walked_s_ += interval_s;
  }

  /// Rotation from the gyro's axes to east and north, counter-clockwise, rad; zero without a field.
  [[nodiscard]] double correction() const {
    return sum_.isZero(0.0) ? 0.0 : std::atan2(sum_.x(), sum_.y()) - declination_.radians();
  }
  /// Of the correction, rad²; falls with the time walked.
  [[nodiscard]] double variance() const {
    if (!p_.on) return 0.0;
    return p_.sigma_rad * p_.sigma_rad * p_.correlation_s / std::max(p_.correlation_s, walked_s_);
  }
  /// Readings by status.
  [[nodiscard]] const SensorReport& report() const { return report_; }

 private:
  MeanFieldNorthParameters p_;
  Angle declination_;
  Eigen::Vector2d recent_uT_ = Eigen::Vector2d::Zero(), sum_ = Eigen::Vector2d::Zero();
  double walked_s_ = 0.0;
  std::optional<LogTime> last_;
  SensorReport report_;
};

}  // namespace wayfare
