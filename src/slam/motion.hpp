#pragma once

#include <optional>

#include <Eigen/Core>

#include <wayfare/core/se2.hpp>
#include <wayfare/core/time.hpp>
#include <wayfare/motion/differential_drive_model.hpp>

namespace wayfare {

/// A motion with its standard deviation, in the frame at its end.
struct Motion {
  SE2d increment;
  Eigen::Vector3d sigma = Eigen::Vector3d::Zero();  ///< m, m, rad

  [[nodiscard]] Eigen::Matrix3d covariance() const { return sigma.cwiseAbs2().asDiagonal(); }
};

/// Predicts the next scan's pose from odometry, or at constant velocity.
class MotionModel {
 public:
  MotionModel(const MotionNoise& odometry, const MotionNoise& constant_velocity)
      : odometry_noise_(odometry), velocity_noise_(constant_velocity) {}

  /// From the last scan to `time`: the odometry increment if both ends are known, else at the
  /// velocity between the last two scans.
  [[nodiscard]] Motion predict(LogTime time, const std::optional<SE2d>& odometry) const;

  /// Adds a scan's estimated pose.
  void update(LogTime time, const SE2d& pose, const std::optional<SE2d>& odometry);
  /// Replaces the last scan's pose, without a change of velocity.
  void correct(const SE2d& pose) {
    if (!last_) return;
    velocity_from_.pose = pose * last_->pose.inverse() * velocity_from_.pose;
    last_->pose = pose;
  }

 private:
  friend struct SubmapState;  // saves and restores it

  struct Placed {
    LogTime time;
    SE2d pose;
    std::optional<SE2d> odometry;
  };

  struct Start {
    LogTime time;
    SE2d pose;
  };

  MotionNoise odometry_noise_, velocity_noise_;
  std::optional<Placed> last_;
  Start velocity_from_;                                 // start of the latest velocity measurement
  double mean_interval_s_ = 0.0;                        // mean interval between scans
  Eigen::Vector3d velocity_ = Eigen::Vector3d::Zero();  // body frame, per second
};

/// Whether odometry differs from the constant-velocity prediction by more than the latter's error.
/// (The error of odometry itself grows with the size of a jump in it.)
[[nodiscard]] bool contradicts(const Motion& odometry, const Motion& by_velocity, double sigmas);

/// Whether it differs so much that even a fair match at the odometry pose must be verified.
[[nodiscard]] bool jumps(const Motion& odometry, const Motion& by_velocity);

}  // namespace wayfare
