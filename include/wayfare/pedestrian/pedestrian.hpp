#pragma once

// Pedestrian dead reckoning: steps, their lengths and directions.

#include <cmath>
#include <optional>

#include <Eigen/Core>

#include <wayfare/inertial/ahrs.hpp>
#include <wayfare/pedestrian/detail/magnetic_heading_drift.hpp>
#include <wayfare/pedestrian/detail/mean_field_north.hpp>
#include <wayfare/pedestrian/detail/straight_walk.hpp>
#include <wayfare/pedestrian/detail/walking_heading.hpp>
#include <wayfare/pedestrian/parameters.hpp>
#include <wayfare/pedestrian/step_detector.hpp>

namespace wayfare {

/// Causal. Steps are reported with a short delay, the first ones of a walk together. `Length` is a
/// StepLengthModel.
template <class Length>
class BasicPedestrian {
  static_assert(detail::check_step_length<Length>());

 public:
  using Parameters = BasicPedestrianParameters<Length>;  ///< with the step length model

  /// Without readings; the parameters are kept.
  explicit BasicPedestrian(const Parameters& parameters = {})
      : p_(parameters),
        ahrs_(attitude_parameters(parameters)),
        detector_(parameters.steps),
        heading_(parameters.heading_time_s),
        straight_(parameters.straight),
        magnetic_drift_(parameters.magnetic_drift),
        mean_field_(parameters.mean_field, parameters.ahrs.declination),
        covariance_(parameters) {}

  /// Passes the pose after each step to `sink(const PedestrianPose&)`.
  template <class Sink>
  MargUpdateStatus add(const MargSample& s, Sink&& sink) {
    MargUpdateStatus status = ahrs_.add(s);
    if (magnetic_drift_.on() || mean_field_.on()) status.magnetometer = add_field(s);
    if (status.gyro == UpdateStatus::used || status.gyro == UpdateStatus::saturated)
      update_heading(s);
    if (status.accelerometer != UpdateStatus::missing && status.accelerometer != UpdateStatus::late)
      detector_.add(s.time, s.specific_force_mps2, [&](const Step& step) { add_step(step, sink); });
    return status;
  }
  /// The same, without the poses.
  MargUpdateStatus add(const MargSample& s) {
    return add(s, [](const PedestrianPose&) {});
  }

  /// External heading of the forward axis, as Ahrs::add_heading(): counter-clockwise from x, rad²
  /// of an error independent between fixes. Needs PedestrianParameters::ahrs.heading_history_s.
  /// Affects steps reported later. Not used with magnetic_drift or mean_field.
  UpdateStatus add_heading(LogTime time, Angle heading, double variance) {
    if (magnetic_drift_.on() || mean_field_.on()) return UpdateStatus::waiting;
    const double before = forward_radians();
    const UpdateStatus status = ahrs_.add_heading({time, Angle::degrees(90) - heading, variance});
    if (status == UpdateStatus::used) heading_.rotate(wrap_to_pi(forward_radians() - before));
    return status;
  }

  /// After the last step.
  [[nodiscard]] const PedestrianPose& pose() const { return pose_; }
  /// All steps before this time have been reported: the walker has not moved since the last.
  /// Nothing before the first reading.
  [[nodiscard]] std::optional<LogTime> settled() const { return detector_.settled(); }
  /// The pose of the last step with the heading of `time`, of the last twenty seconds and up to
  /// settled(). Nothing before the attitude is initialised.
  [[nodiscard]] std::optional<PedestrianPose> pose_at_rest(LogTime time) const {
    const WalkingHeading::Entry* h = heading_.at(time);
    if (h == nullptr) return std::nullopt;
    PedestrianPose pose = pose_;
    pose.time = time;
    pose.heading =
        Angle::radians(walking_radians(*h) - drift_ + mean_field_.correction()).wrapped();
    return pose;
  }
  /// Attitude filter.
  [[nodiscard]] const Ahrs<frame::Enu>& ahrs() const { return ahrs_; }
  /// Of the walking direction in the unit's axes.
  [[nodiscard]] const WalkingDirection& direction() const { return direction_; }
  /// Gyro drift by an uncalibrated magnetometer.
  [[nodiscard]] const MagneticHeadingDrift& magnetic_drift() const { return magnetic_drift_; }
  /// North by the mean field of the walk.
  [[nodiscard]] const MeanFieldNorth& mean_field() const { return mean_field_; }
  /// Counts so far.
  [[nodiscard]] PedestrianReport report() const {
    PedestrianReport r = report_;
    r.ahrs = ahrs_.report();
    if (magnetic_drift_.on()) r.ahrs.magnetometer = magnetic_drift_.report();
    if (mean_field_.on()) r.ahrs.magnetometer = mean_field_.report();
    return r;
  }

 private:
  static AhrsParameters attitude_parameters(const Parameters& p) {
    AhrsParameters ahrs = p.ahrs;
    ahrs.heading_axis = p.forward;
    if (p.magnetic_drift.offset_sigma_uT > 0.0 || p.mean_field.on) ahrs.use_magnetometer = false;
    return ahrs;
  }

  UpdateStatus add_field(const MargSample& s) {
    if (!ahrs_.ready()) return UpdateStatus::waiting;
    const auto q = ahrs_.q_world_body();
    return mean_field_.on() ? mean_field_.add(s.time, q, s.magnetic_field_uT)
                            : magnetic_drift_.add(s.time, q, s.magnetic_field_uT);
  }

  [[nodiscard]] double forward_radians() const { return forward_radians(ahrs_.q_world_body()); }
  [[nodiscard]] double forward_radians(const SO3d& q_world_body) const {
    const Eigen::Vector3d axis = q_world_body * p_.forward;
    return std::atan2(axis.y(), axis.x());
  }

  /// Stores the heading of the sensor's axis until the steps of its time are reported.
  void update_heading(const MargSample& s) {
    if (!ahrs_.ready()) return;
    const auto q = ahrs_.q_world_body();
    const double heading = forward_radians(q) + magnetic_drift_.correction();
    const double dt = heading_.add(s.time, heading, [this] {
      return magnetic_drift_.on() ? magnetic_drift_.variance() : ahrs_.heading_variance();
    });
    if (s.specific_force_mps2.allFinite())
      direction_.add(q * s.specific_force_mps2,
                     Angle::radians(heading_.now() - magnetic_drift_.correction()), dt);
  }

  [[nodiscard]] double walking_radians(const WalkingHeading::Entry& h) const {
    return h.radians + (p_.axis == WalkingAxis::principal ? direction_.offset().radians() : 0.0);
  }

  template <class Sink>
  void add_step(const Step& step, Sink&& sink) {
    ++report_.steps;
    const WalkingHeading::Entry* h = heading_.at(step.time);
    if (h == nullptr) {
      ++report_.without_heading;
      return;
    }
    const double length = p_.length(step);
    if (!std::isfinite(length)) {
      ++report_.without_length;
      return;
    }
    drift_ = straight_.step(step.time, h->radians);
    const double heading = walking_radians(*h) - drift_;
    path_m_ += length * Eigen::Vector2d(std::cos(heading), std::sin(heading));
    mean_field_.step(step.interval_s);
    const double north = mean_field_.correction();
    const Eigen::Vector2d along(std::cos(heading + north), std::sin(heading + north));
    pose_.position_m = Eigen::Rotation2Dd(north) * path_m_;
    pose_.time = step.time;
    pose_.heading = Angle::radians(heading + north).wrapped();
    pose_.step = step;
    pose_.length_m = length;
    pose_.covariance =
        covariance_.step(length, along, pose_.position_m, h->variance + mean_field_.variance());
    report_.distance_m += length;
    sink(static_cast<const PedestrianPose&>(pose_));
  }

  Parameters p_;
  Ahrs<frame::Enu> ahrs_;
  StepDetector detector_;
  WalkingHeading heading_;
  WalkingDirection direction_;
  StraightWalk straight_;
  double drift_ = 0.0;  // of the heading at the last step
  MagneticHeadingDrift magnetic_drift_;
  MeanFieldNorth mean_field_;
  Eigen::Vector2d path_m_ = Eigen::Vector2d::Zero();  // before the turn to north
  WalkCovariance covariance_;
  PedestrianPose pose_;
  PedestrianReport report_;
};

}  // namespace wayfare
