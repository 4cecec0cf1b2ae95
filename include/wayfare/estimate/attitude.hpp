#pragma once

// How a body is turned in a local level frame, and what every estimator of it offers.

#include <cmath>
#include <concepts>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <wayfare/core/angle.hpp>
#include <wayfare/core/frame.hpp>
#include <wayfare/core/so3.hpp>
#include <wayfare/measure/marg.hpp>

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

/// Rotations about z (first), y and x of the turned body: yaw is positive from x to y of the world,
/// so clockwise from north in NED and counter-clockwise from east in ENU.
struct RollPitchYaw {
  Angle roll;
  Angle pitch;
  Angle yaw;
};

/// At a pitch of ±90° only yaw ∓ roll is defined, and roll is taken as zero.
template <class T>
[[nodiscard]] RollPitchYaw roll_pitch_yaw(const SO3<T>& q_world_body) {
  const Eigen::Matrix3d r = q_world_body.template cast<double>().matrix();
  const double cos_pitch = std::hypot(r(0, 0), r(1, 0));
  const Angle pitch = Angle::radians(std::atan2(-r(2, 0), cos_pitch));
  if (cos_pitch < 1e-6) return {Angle{}, pitch, Angle::radians(std::atan2(-r(0, 1), r(1, 1)))};
  return {Angle::radians(std::atan2(r(2, 1), r(2, 2))), pitch,
          Angle::radians(std::atan2(r(1, 0), r(0, 0)))};
}

template <class T>
[[nodiscard]] SO3<T> from_roll_pitch_yaw(const RollPitchYaw& a) {
  const auto about = [](int axis, Angle angle) {
    Eigen::Vector3d v = Eigen::Vector3d::Zero();
    v[axis] = angle.radians();
    return SO3d::exp(v);
  };
  return (about(2, a.yaw) * about(1, a.pitch) * about(0, a.roll)).template cast<T>();
}

/// What became of one reading.
enum class Intake {
  used,       ///< it moved the estimate
  waiting,    ///< held back: no attitude yet, or no gyro reading near its time
  missing,    ///< not a number: the sensor gave nothing
  late,       ///< not after the one before it
  saturated,  ///< at the end of the sensor's range, or beyond what it can measure
  disturbed,  ///< a magnetic field that is not the Earth's as known here
};

/// What became of one sensor's reading at each.
struct MargIntake {
  Intake gyro = Intake::missing;
  Intake accelerometer = Intake::missing;
  Intake magnetometer = Intake::missing;
};

/// Causal estimators of attitude from inertial and magnetic readings, with one interface. `World`
/// is the frame `q_world_body` leads to. A reading that cannot be used leaves the estimate as it
/// was; the return value says why.
template <class E>
concept AttitudeEstimator = requires(E e, const E& c, const MargSample& sample) {
  typename E::World;
  typename E::Scalar;
  requires LevelFrame<typename E::World>;
  { e.add(sample) } -> std::same_as<MargIntake>;
  { c.ready() } -> std::same_as<bool>;
  { c.q_world_body() } -> std::same_as<SO3<typename E::Scalar>>;
};

}  // namespace wayfare
