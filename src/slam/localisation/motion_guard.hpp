#pragma once

#include <algorithm>
#include <cmath>
#include <optional>

#include <wayfare/core/gaussian.hpp>
#include <wayfare/core/time.hpp>
#include <wayfare/slam/detail/motion.hpp>
#include <wayfare/slam/detail/scans.hpp>
#include <wayfare/slam/localisation.hpp>

namespace wayfare {

/// Converts odometry at the scans' times to motions; replaces implausible ones by a prediction.
class MotionGuard {
 public:
  explicit MotionGuard(const LocalisationOptions& options) : options_(options) {}

  struct Step {
    Gaussian<SE2d> motion;
    bool refused = false;
  };

  /// From the previous time to `time`.
  Step step(LogTime time, const std::optional<SE2d>& odometry) {
    const std::optional<SE2d> given =
        odometry && detail::finite(*odometry) ? odometry : std::nullopt;
    Step step{{SE2d::identity(), Eigen::Matrix3d::Zero()}, !given};
    if (time_) {
      const double dt = to_seconds(time - *time_);
      if (const auto increment = plausible_increment(given, dt)) {
        velocity_ = possible_velocity(increment->log() / dt);
        step = {uncertain(*increment, options_.odometry), false};
      } else {
        constexpr double kLongest_s = 0.5;  // no extrapolation through a gap in the log
        const SE2d guess = SE2d::exp(velocity_ * std::min(dt, kLongest_s));
        step = {uncertain(guess, options_.constant_velocity), true};
      }
    }
    time_ = time;
    odometry_ = given;
    return step;
  }

  /// Estimated pose at that time: gives the velocity when there is no odometry.
  void update(const SE2d& pose) {
    const double dt = estimated_ ? to_seconds(*time_ - estimated_->time) : 0.0;
    if (!odometry_ && dt >= kShortestInterval_s) velocity_ = pose.minus(estimated_->pose) / dt;
    estimated_ = Estimated{*time_, pose};
  }

  [[nodiscard]] const std::optional<LogTime>& time() const { return time_; }

 private:
  [[nodiscard]] std::optional<SE2d> plausible_increment(const std::optional<SE2d>& odometry,
                                                        double dt) const {
    if (!odometry || !odometry_) return std::nullopt;
    const SE2d increment = odometry_->inverse() * *odometry;
    const double turn = std::abs(increment.heading().radians());
    // Timestamps jitter by tenths of a second: the motion possible in 0.5 s is always accepted.
    const double time = std::max(dt, 0.5);
    const bool possible = increment.translation().norm() <= options_.max_speed_m_s * time &&
                          turn <= options_.max_turn_rate.radians() * time;
    return possible ? std::optional(increment) : std::nullopt;
  }

  /// Within the robot's limits: the motion accepted over a short interval may be much faster.
  [[nodiscard]] Eigen::Vector3d possible_velocity(const Eigen::Vector3d& velocity) const {
    const double over = std::max(velocity.head<2>().norm() / options_.max_speed_m_s,
                                 std::abs(velocity[2]) / options_.max_turn_rate.radians());
    return over > 1.0 ? Eigen::Vector3d(velocity / over) : velocity;
  }

  static Gaussian<SE2d> uncertain(const SE2d& increment, const MotionNoise& noise) {
    // Options that are not finite: the motion is unknown, the particles stay finite.
    constexpr double kUnknown = 1e3;
    const Eigen::Vector3d sigma = sigma_of(increment, noise);
    const Eigen::Vector3d known = (sigma.array().abs() < kUnknown).select(sigma, kUnknown);
    return {increment, known.cwiseAbs2().asDiagonal()};
  }

  const LocalisationOptions& options_;
  std::optional<LogTime> time_;
  std::optional<SE2d> odometry_;
  struct Estimated {
    LogTime time;
    SE2d pose;
  };
  std::optional<Estimated> estimated_;
  Eigen::Vector3d velocity_ = Eigen::Vector3d::Zero();  // body frame, per second
};

}  // namespace wayfare
