#pragma once

// Attitude in a local level frame, and the interface of its estimators.

#include <cmath>
#include <concepts>
#include <cstdint>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <wayfare/core/angle.hpp>
#include <wayfare/core/detail/eigen_alignment.hpp>
#include <wayfare/core/frame.hpp>
#include <wayfare/core/se3.hpp>
#include <wayfare/sensors/measurements.hpp>

namespace wayfare {

/// Local level frames of attitudes: frame::Ned and frame::Enu.
template <class World>
concept LevelFrame = std::same_as<World, frame::Ned> || std::same_as<World, frame::Enu>;

/// Rotates east-north-up coordinates to `World`.
template <LevelFrame World, class T>
[[nodiscard]] SO3<T> rotation_from_enu() {
  if constexpr (std::same_as<World, frame::Enu>) return SO3<T>::identity();
  // Half a turn about the bisector of east and north swaps the two and turns up to down.
  return SO3<T>(Eigen::Quaternion<T>(T(0), T(1), T(1), T(0)));
}

/// Compass direction of the body's x axis, clockwise from north; roll, pitch and yaw are in
/// core/se3.hpp.
template <LevelFrame World, class T>
[[nodiscard]] Angle compass_of_x(const SO3<T>& q_world_body) {
  const Eigen::Matrix<T, 3, 1> x = q_world_body.matrix().col(0);
  if constexpr (std::same_as<World, frame::Ned>) return Angle::radians(std::atan2(x.y(), x.x()));
  return Angle::radians(std::atan2(x.x(), x.y()));
}

/// Result of adding one reading.
enum class UpdateStatus {
  used,       ///< it updated the estimate
  waiting,    ///< no attitude yet, or no gyro reading near its time
  missing,    ///< not finite, or without a direction: no measurement
  late,       ///< not after the previous one
  saturated,  ///< at or beyond the sensor's range
  disturbed,  ///< rejected: magnetic disturbance, or external heading outside the gate
};

/// Result of adding one sample.
struct MargUpdateStatus {
  UpdateStatus gyro = UpdateStatus::missing;           ///< its rate
  UpdateStatus accelerometer = UpdateStatus::missing;  ///< its specific force
  UpdateStatus magnetometer = UpdateStatus::missing;   ///< its field
};

/// Causal attitude estimators from inertial and magnetic readings. `World` is the target frame of
/// `q_world_body`. A reading that cannot be used leaves the estimate unchanged; the return value
/// says why.
template <class E>
concept AttitudeEstimator = requires(E e, const E& c, const MargSample& sample) {
  typename E::World;
  typename E::Scalar;
  requires LevelFrame<typename E::World>;
  { e.add(sample) } -> std::same_as<MargUpdateStatus>;
  { c.ready() } -> std::same_as<bool>;
  { c.q_world_body() } -> std::same_as<SO3<typename E::Scalar>>;
};

/// Counts of one sensor's readings by status.
struct SensorReport {
  std::uint64_t used = 0;       ///< that updated the estimate
  std::uint64_t waiting = 0;    ///< without an attitude to update
  std::uint64_t missing = 0;    ///< not finite, or without a direction
  std::uint64_t late = 0;       ///< not after the previous one
  std::uint64_t saturated = 0;  ///< at or beyond the sensor's range
  std::uint64_t disturbed = 0;  ///< rejected

  /// Counts `status` and returns it.
  UpdateStatus note(UpdateStatus status) {
    static constexpr std::uint64_t SensorReport::*kCounts[] = {
        &SensorReport::used, &SensorReport::waiting,   &SensorReport::missing,
        &SensorReport::late, &SensorReport::saturated, &SensorReport::disturbed};
    ++(this->*kCounts[static_cast<int>(status)]);
    return status;
  }
};

/// Events of an attitude filter.
struct AhrsReport {
  SensorReport gyro;                 ///< by status
  SensorReport accelerometer;        ///< by status
  SensorReport magnetometer;         ///< by status
  SensorReport external;             ///< external headings
  std::uint64_t restarts = 0;        ///< after a gyro gap or a clock set back
  std::uint64_t level_resets = 0;    ///< attitude inconsistent with gravity
  std::uint64_t heading_resets = 0;  ///< heading inconsistent with the field or external headings
};

/// Normalised innovations squared; NaN before the first.
template <class T>
struct AhrsNis {
  T velocity_east;   ///< of the velocity by the accelerometer, east
  T velocity_north;  ///< the same, north
  T heading;         ///< of the magnetic heading
  T external;        ///< external heading
};

}  // namespace wayfare
