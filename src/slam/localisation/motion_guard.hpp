#pragma once

#include <optional>

#include <wayfare/core/gaussian.hpp>
#include <wayfare/core/time.hpp>
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
  Step step(LogTime time, const std::optional<SE2d>& odometry);

  /// Estimated pose at that time: gives the velocity when there is no odometry.
  void update(const SE2d& pose);

  [[nodiscard]] const std::optional<LogTime>& time() const { return time_; }

 private:
  [[nodiscard]] std::optional<SE2d> plausible_increment(const std::optional<SE2d>& odometry,
                                                        double dt) const;

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
