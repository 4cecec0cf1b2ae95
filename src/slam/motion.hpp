#pragma once

#include <optional>

#include <Eigen/Core>

#include <wayfare/core/se2.hpp>
#include <wayfare/core/time.hpp>
#include <wayfare/motion/motion_noise.hpp>

namespace wayfare {

/// A motion and how far it may be off, in the frame of where it ends.
struct Motion {
  SE2d increment;
  Eigen::Vector3d sigma = Eigen::Vector3d::Zero();  ///< m, m, rad

  [[nodiscard]] Eigen::Matrix3d covariance() const { return sigma.cwiseAbs2().asDiagonal(); }
};

/// Expects the next scan where odometry says, or where the robot gets by going on as it did.
class MotionModel {
 public:
  MotionModel(const MotionNoise& odometry, const MotionNoise& constant_velocity)
      : odometry_noise_(odometry), velocity_noise_(constant_velocity) {}

  /// From the scan last told of to `time`: the increment of odometry where both ends are known,
  /// else by the velocity between the last two scans.
  [[nodiscard]] Motion predict(LogTime time, const std::optional<SE2d>& odometry) const;

  /// A scan was placed at `pose`.
  void tell(LogTime time, const SE2d& pose, const std::optional<SE2d>& odometry);
  /// The scan last told of turned out to be at `pose`: that was no motion.
  void correct(const SE2d& pose) {
    if (!last_) return;
    from_.pose = pose * last_->pose.inverse() * from_.pose;
    last_->pose = pose;
  }

 private:
  friend struct SubmapState;  // saves and restores it

  struct Seen {
    LogTime time;
    SE2d pose;
    std::optional<SE2d> odometry;
  };

  struct Start {
    LogTime time;
    SE2d pose;
  };

  MotionNoise odometry_noise_, velocity_noise_;
  std::optional<Seen> last_;
  Start from_;                                          // where the latest velocity was measured to
  double usual_s_ = 0.0;                                // from scan to scan
  Eigen::Vector3d velocity_ = Eigen::Vector3d::Zero();  // body frame, per second
};

/// Whether odometry leads farther from where the robot gets by going on than that should err. (What
/// odometry itself should err grows with a jump of it.)
[[nodiscard]] bool contradicts(const Motion& odometry, const Motion& going_on, double sigmas);

/// Whether it leads so far from there that even a fair match where it leads is worth a doubt.
[[nodiscard]] bool leaps(const Motion& odometry, const Motion& going_on);

}  // namespace wayfare
