#pragma once

#include <algorithm>
#include <cmath>
#include <optional>

#include <wayfare/core/time.hpp>
#include <wayfare/slam/detail/motion.hpp>
#include <wayfare/slam/detail/pose_measures.hpp>
#include <wayfare/slam/monte_carlo.hpp>

namespace wayfare::detail {

/// Converts odometry at the scans' times to motions; replaces implausible ones by a prediction.
template <class Pose>
class MotionGuard {
 public:
  explicit MotionGuard(const MonteCarloOptions& options) : options_(options) {}

  struct Step {
    Pose increment;
    bool refused = false;    // the odometry
    bool predicted = false;  // at constant velocity
  };

  /// From the previous time to `time`.
  Step step(LogTime time, const std::optional<Pose>& odometry) {
    const std::optional<Pose> given =
        odometry && has_finite_value(*odometry) ? odometry : std::nullopt;
    Step step{Pose::identity(), !given};
    if (time_) {
      const double dt = to_seconds(time - *time_);
      if (const auto increment = plausible_increment(given, dt)) {
        velocity_ = possible_velocity(increment->log() / dt);
        step = {*increment};
      } else {
        constexpr double kLongest_s = 0.5;  // no extrapolation through a gap in the log
        step = {Pose::exp(velocity_ * std::min(dt, kLongest_s)), true, true};
      }
    }
    time_ = time;
    odometry_ = given;
    return step;
  }

  /// Estimated pose at that time: gives the velocity when there is no odometry.
  void update(const Pose& pose) {
    const double dt = estimated_ ? to_seconds(*time_ - estimated_->time) : 0.0;
    if (!odometry_ && dt >= kShortestInterval_s) velocity_ = pose.minus(estimated_->pose) / dt;
    estimated_ = Estimated{*time_, pose};
  }

  [[nodiscard]] const std::optional<LogTime>& time() const { return time_; }

 private:
  using Velocity = TangentOf<Pose>;
  static constexpr int kPlace = kPlaceDof<Pose>;

  [[nodiscard]] std::optional<Pose> plausible_increment(const std::optional<Pose>& odometry,
                                                        double dt) const {
    if (!odometry || !odometry_) return std::nullopt;
    const Pose increment = odometry_->inverse() * *odometry;
    // Timestamps jitter by tenths of a second: the motion possible in 0.5 s is always accepted.
    const double time = std::max(dt, 0.5);
    const bool possible = increment.translation().norm() <= options_.max_speed_m_s * time &&
                          turn_of(increment) <= options_.max_turn_rate.radians() * time;
    return possible ? std::optional(increment) : std::nullopt;
  }

  /// Within the robot's limits: the motion accepted over a short interval may be much faster.
  [[nodiscard]] Velocity possible_velocity(const Velocity& velocity) const {
    const double over = std::max(
        velocity.template head<kPlace>().norm() / options_.max_speed_m_s,
        velocity.template tail<Pose::kDof - kPlace>().norm() / options_.max_turn_rate.radians());
    return over > 1.0 ? Velocity(velocity / over) : velocity;
  }

  MonteCarloOptions options_;
  std::optional<LogTime> time_;
  std::optional<Pose> odometry_;
  struct Estimated {
    LogTime time;
    Pose pose;
  };
  std::optional<Estimated> estimated_;
  Velocity velocity_ = Velocity::Zero();  // body frame, per second
};

}  // namespace wayfare::detail
