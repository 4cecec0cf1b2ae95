#pragma once

#include <optional>

#include <wayfare/core/gaussian.hpp>
#include <wayfare/core/time.hpp>
#include <wayfare/slam/localisation.hpp>

namespace wayfare {

/// Turns odometry at the scans' times into motions, and what cannot have been one into a guess.
class MotionGuard {
 public:
  explicit MotionGuard(const LocalisationOptions& options) : options_(options) {}

  struct Step {
    Gaussian<SE2d> motion;
    bool refused = false;
  };

  /// From the time last told of to `time`.
  Step step(LogTime time, const std::optional<SE2d>& odometry);

  /// Where the robot turned out to be at that time: its velocity, where odometry does not say.
  void tell(const SE2d& pose);

  [[nodiscard]] const std::optional<LogTime>& time() const { return time_; }

 private:
  [[nodiscard]] std::optional<SE2d> believed(const std::optional<SE2d>& odometry, double dt) const;

  const LocalisationOptions& options_;
  std::optional<LogTime> time_;
  std::optional<SE2d> odometry_;
  struct Seen {
    LogTime time;
    SE2d pose;
  };
  std::optional<Seen> seen_;
  Eigen::Vector3d velocity_ = Eigen::Vector3d::Zero();  // body frame, per second
};

}  // namespace wayfare
