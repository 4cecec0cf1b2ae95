#pragma once

// How a body is turned in a local level frame, and what every estimator of it offers.

#include <cmath>
#include <concepts>
#include <cstdint>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <wayfare/core/angle.hpp>
#include <wayfare/core/frame.hpp>
#include <wayfare/core/so3.hpp>
#include <wayfare/sensors/marg.hpp>

namespace wayfare {

/// The local level frames attitudes are given in: frame::Ned and frame::Enu.
template <class World>
concept LevelFrame = std::same_as<World, frame::Ned> || std::same_as<World, frame::Enu>;

/// Takes east-north-up coordinates to those of `World`.
template <LevelFrame World, class T>
[[nodiscard]] SO3<T> rotation_from_enu() {
  if constexpr (std::same_as<World, frame::Enu>) return SO3<T>::identity();
  // Half a turn about the bisector of east and north swaps the two and turns up to down.
  return SO3<T>(Eigen::Quaternion<T>(T(0), T(1), T(1), T(0)));
}

/// Where the body's x axis points, clockwise from north as a compass has it; its roll, pitch and
/// yaw are in core/roll_pitch_yaw.hpp.
template <LevelFrame World, class T>
[[nodiscard]] Angle compass_of_x(const SO3<T>& q_world_body) {
  const Eigen::Matrix<T, 3, 1> x = q_world_body.matrix().col(0);
  if constexpr (std::same_as<World, frame::Ned>) return Angle::radians(std::atan2(x.y(), x.x()));
  return Angle::radians(std::atan2(x.x(), x.y()));
}

/// What became of one reading.
enum class UpdateStatus {
  used,       ///< it moved the estimate
  waiting,    ///< held back: no attitude yet, or no gyro reading near its time
  missing,    ///< not a number: the sensor gave nothing
  late,       ///< not after the one before it
  saturated,  ///< at the end of the sensor's range, or beyond what it can measure
  disturbed,  ///< a magnetic field that is not the Earth's as known here, a heading that is not
              ///< ours
};

/// What became of one sensor's reading at each.
struct MargUpdateStatus {
  UpdateStatus gyro = UpdateStatus::missing;
  UpdateStatus accelerometer = UpdateStatus::missing;
  UpdateStatus magnetometer = UpdateStatus::missing;
};

/// Causal estimators of attitude from inertial and magnetic readings, with one interface. `World`
/// is the frame `q_world_body` leads to. A reading that cannot be used leaves the estimate as it
/// was; the return value says why.
template <class E>
concept AttitudeEstimator = requires(E e, const E& c, const MargSample& sample) {
  typename E::World;
  typename E::Scalar;
  requires LevelFrame<typename E::World>;
  { e.add(sample) } -> std::same_as<MargUpdateStatus>;
  { c.ready() } -> std::same_as<bool>;
  { c.q_world_body() } -> std::same_as<SO3<typename E::Scalar>>;
};

/// What became of one sensor's readings.
struct SensorReport {
  std::uint64_t used = 0;
  std::uint64_t waiting = 0;
  std::uint64_t missing = 0;
  std::uint64_t late = 0;
  std::uint64_t saturated = 0;
  std::uint64_t disturbed = 0;

  /// Counts `intake` and passes it on.
  UpdateStatus note(UpdateStatus status) {
    switch (status) {
      case UpdateStatus::used:
        ++used;
        break;
      case UpdateStatus::waiting:
        ++waiting;
        break;
      case UpdateStatus::missing:
        ++missing;
        break;
      case UpdateStatus::late:
        ++late;
        break;
      case UpdateStatus::saturated:
        ++saturated;
        break;
      case UpdateStatus::disturbed:
        ++disturbed;
        break;
    }
    return status;
  }
};

/// What an attitude filter met on its way.
struct AhrsReport {
  SensorReport gyro;
  SensorReport accelerometer;
  SensorReport magnetometer;
  SensorReport outside;             ///< headings told from outside
  std::uint64_t restarts = 0;       ///< after a gap of the gyro, or its clock set back
  std::uint64_t levelled_anew = 0;  ///< the attitude did not fit gravity any more
  std::uint64_t headings_taken =
      0;  ///< the heading did not fit the field, or what was told, any more
};

/// Squares of innovations over their variances; NaN before the first.
template <class T>
struct AhrsNis {
  T velocity_east;
  T velocity_north;
  T heading;
  T outside;  ///< of a heading told from outside
};

}  // namespace wayfare
