#pragma once

// Pedestrian dead reckoning: steps, their lengths, and the way they go.

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include <Eigen/Core>

#include <wayfare/estimate/ahrs.hpp>
#include <wayfare/estimate/step_detector.hpp>
#include <wayfare/estimate/step_length.hpp>
#include <wayfare/estimate/walking_direction.hpp>
#include <wayfare/measure/recording.hpp>

namespace wayfare {

/// Where the direction of walking is taken from.
enum class WalkingAxis {
  sensor,     ///< an axis of the sensor, as held in the hand or worn on head, chest or hip
  principal,  ///< found from how the body sways: the sensor may sit any way round
};

/// For an attitude indoors, of a unit whose gyro bias was taken off before, as phones do: the field
/// is bent everywhere, so none of it is refused and each reading counts for little.
[[nodiscard]] inline AhrsParameters indoor_ahrs_parameters() {
  AhrsParameters p;
  p.bias_sigma *= 0.03;
  p.heading_density *= 2.0;
  p.field_norm_gate = 1.0;
  p.field_dip_gate = Angle::degrees(90.0);
  return p;
}

struct PedestrianParameters {
  StepParameters steps;
  StepLength length = KimStep{};
  AhrsParameters ahrs = indoor_ahrs_parameters();
  WalkingAxis axis = WalkingAxis::sensor;
  /// The sensor's axis that points where the body walks; y on a phone.
  Eigen::Vector3d forward = Eigen::Vector3d::UnitY();
  /// The heading is averaged for so long before a step, s: heads and hands turn to and fro.
  double heading_time_s = 0.5;
  /// What is unknown of the length of each step, and of all alike, as part of it.
  double length_sigma = 0.1;
  double length_scale_sigma = 0.06;
  /// What is unknown of the way each step goes, and of all alike, rad; beside the attitude's own.
  double direction_sigma = 0.1;
  double direction_offset_sigma = 0.15;
  /// Curved ways made straight (Borenstein and Ojeda 2010): part of a turn slower than the limit,
  /// rad/s, that is taken for the gyro's drift at each step. Zero leaves them as they are. Helps
  /// along corridors, harms on bends.
  double straighten = 0.0;
  double straighten_limit = 0.035;
};

/// After a step. World axes: x east, y north where there is a magnetometer, else as at the start.
struct PedestrianPose {
  LogTime time;
  Eigen::Vector2d position_m = Eigen::Vector2d::Zero();
  Angle heading;                                         ///< of walking, counter-clockwise from x
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< x, y in m, heading in rad
  Step step{};
  double length_m = 0.0;

  [[nodiscard]] OdometrySample odometry() const {
    return {time,
            Transform2<frame::Odom, frame::Base>(SE2d(position_m.x(), position_m.y(), heading))};
  }
};

struct PedestrianReport {
  AhrsReport ahrs;
  std::uint64_t steps = 0;
  std::uint64_t without_heading = 0;  ///< steps before there was an attitude
  double walked_m = 0.0;
};

/// Causal. Steps come out shortly after they were made, the first of a walk together.
class Pedestrian {
 public:
  explicit Pedestrian(const PedestrianParameters& parameters = {})
      : p_(parameters), ahrs_(parameters.ahrs), detector_(parameters.steps) {}

  /// Hands the pose after each step to `sink(const PedestrianPose&)`.
  template <class Sink>
  MargIntake add(const MargSample& s, Sink&& sink) {
    const MargIntake intake = ahrs_.add(s);
    if (intake.gyro == Intake::used || intake.gyro == Intake::saturated) follow(s);
    if (intake.accelerometer != Intake::missing && intake.accelerometer != Intake::late)
      detector_.add(s.time, s.specific_force_mps2, [&](const Step& step) { walk(step, sink); });
    return intake;
  }
  MargIntake add(const MargSample& s) {
    return add(s, [](const PedestrianPose&) {});
  }

  [[nodiscard]] const PedestrianPose& pose() const { return pose_; }
  [[nodiscard]] const Ahrs<frame::Enu>& ahrs() const { return ahrs_; }
  [[nodiscard]] const WalkingDirection& direction() const { return direction_; }
  [[nodiscard]] PedestrianReport report() const {
    PedestrianReport r = report_;
    r.ahrs = ahrs_.report();
    return r;
  }

 private:
  struct Heading {
    LogTime time;
    double radians = 0.0;  ///< not wrapped, averaged
    double variance = 0.0;
  };
  static constexpr std::size_t kHeadings = 1024;
  static constexpr double kSpacing_s = 0.02;

  /// The heading of the sensor's axis, kept until the steps of its time are known.
  void follow(const MargSample& s) {
    if (!ahrs_.ready()) return;
    const auto q = ahrs_.q_world_body();
    const Eigen::Vector3d axis = q * p_.forward;
    const double now = std::atan2(axis.y(), axis.x());
    const double dt = has_heading_ ? to_seconds(s.time - heading_time_) : 0.0;
    if (!has_heading_ || dt < 0.0 || dt > 1.0) {
      unwrapped_ = average_ = now;
      count_ = 0;
    } else {
      unwrapped_ += wrap_to_pi(now - unwrapped_);
      average_ += std::min(1.0, 2.0 * dt / p_.heading_time_s) * (unwrapped_ - average_);
    }
    has_heading_ = true;
    heading_time_ = s.time;
    if (s.specific_force_mps2.allFinite())
      direction_.add(q * s.specific_force_mps2, Angle::radians(unwrapped_), dt);
    if (count_ > 0 && to_seconds(s.time - kept(0).time) < kSpacing_s) return;
    newest_ = (newest_ + 1) % kHeadings;
    headings_[newest_] = {s.time, average_, ahrs_.world_covariance()(2, 2)};
    count_ = std::min(count_ + 1, kHeadings);
  }

  [[nodiscard]] const Heading& kept(std::size_t age) const {
    return headings_[(newest_ + kHeadings - age) % kHeadings];
  }
  [[nodiscard]] const Heading* heading_at(LogTime time) const {
    for (std::size_t age = 0; age < count_; ++age)
      if (kept(age).time <= time) return &kept(age);
    return count_ > 0 ? &kept(count_ - 1) : nullptr;
  }

  template <class Sink>
  void walk(const Step& step, Sink&& sink) {
    ++report_.steps;
    const Heading* h = heading_at(step.time);
    if (h == nullptr) {
      ++report_.without_heading;
      return;
    }
    const double length = length_of(step, p_.length);
    const double offset = p_.axis == WalkingAxis::principal ? direction_.offset().radians() : 0.0;
    const double heading = h->radians + offset - straightened(step.time, h->radians);
    const Eigen::Vector2d along(std::cos(heading), std::sin(heading));
    const Eigen::Vector2d across(-along.y(), along.x());
    pose_.position_m += length * along;
    pose_.time = step.time;
    pose_.heading = Angle::radians(heading).wrapped();
    pose_.step = step;
    pose_.length_m = length;
    report_.walked_m += length;
    uncertain(length, along, across, h->variance);
    sink(static_cast<const PedestrianPose&>(pose_));
  }

  /// Errors of each step add up as a walk; those of all steps stretch and turn the whole way about
  /// its start.
  void uncertain(double length, const Eigen::Vector2d& along, const Eigen::Vector2d& across,
                 double heading_variance) {
    const auto square = [](double x) { return x * x; };
    walk_ += square(p_.length_sigma * length) * along * along.transpose() +
             square(p_.direction_sigma * length) * across * across.transpose();
    const Eigen::Vector2d from_start = pose_.position_m;
    const Eigen::Vector2d sideways(-from_start.y(), from_start.x());
    const double common = square(p_.direction_offset_sigma) + heading_variance;
    pose_.covariance.topLeftCorner<2, 2>() =
        walk_ + square(p_.length_scale_sigma) * from_start * from_start.transpose() +
        common * sideways * sideways.transpose();
    pose_.covariance.topRightCorner<2, 1>() = common * sideways;
    pose_.covariance.bottomLeftCorner<1, 2>() = common * sideways.transpose();
    pose_.covariance(2, 2) = common + square(p_.direction_sigma);
  }

  /// What the heading drifted since the start if slow turns are none.
  double straightened(LogTime time, double heading) {
    if (!(p_.straighten > 0.0)) return 0.0;
    const double dt = has_step_ ? to_seconds(time - step_time_) : 0.0;
    has_step_ = true;
    step_time_ = time;
    drifted_ += drift_ * std::clamp(dt, 0.0, 1.0);
    constexpr std::size_t kWindow = 6;
    for (std::size_t i = kWindow; i > 0; --i) recent_[i] = recent_[i - 1];
    recent_[0] = {time, heading, 0.0};
    recent_count_ = std::min(recent_count_ + 1, kWindow + 1);
    const double span = to_seconds(time - recent_[kWindow].time);
    if (recent_count_ > kWindow && span > 0.0 && span < double(kWindow)) {
      const double turn = (heading - recent_[kWindow].radians) / span - drift_;
      if (std::abs(turn) < p_.straighten_limit) drift_ += p_.straighten * turn;
    }
    return drifted_;
  }

  PedestrianParameters p_;
  Ahrs<frame::Enu> ahrs_;
  StepDetector detector_;
  WalkingDirection direction_;
  PedestrianPose pose_;
  PedestrianReport report_;
  std::array<Heading, kHeadings> headings_;
  std::array<Heading, 7> recent_;
  std::size_t newest_ = 0, count_ = 0, recent_count_ = 0;
  Eigen::Matrix2d walk_ = Eigen::Matrix2d::Zero();
  LogTime heading_time_, step_time_;
  double unwrapped_ = 0.0, average_ = 0.0, drift_ = 0.0, drifted_ = 0.0;
  bool has_heading_ = false, has_step_ = false;
};

}  // namespace wayfare
