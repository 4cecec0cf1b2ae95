#pragma once

// The systems that SlamNode runs on laser scans alone.

#include <optional>

#include <wayfare/core/detail/owned.hpp>
#include <wayfare/ros/nodes.hpp>

namespace wayfare::ros {

class LaserSlam {
 public:
  LaserSlam() = default;
  LaserSlam(const LaserSlam&) = delete;
  LaserSlam& operator=(const LaserSlam&) = delete;
  virtual ~LaserSlam() = default;

  /// Of the inertial unit, before the scans that follow it.
  virtual void add(const MargSample& sample) = 0;
  virtual Result<ScanOutcome> add_scan(const wayfare::LaserScan& scan, const MotionHint& hint) = 0;
  /// More scans may follow.
  virtual Result<void> finish() = 0;

  /// Of the part of the map where the robot is: of its piece of the trajectory and those joined to
  /// it.
  [[nodiscard]] virtual Trajectory trajectory() const = 0;
  [[nodiscard]] virtual wayfare::OccupancyGrid map() const = 0;
  [[nodiscard]] virtual PieceStatistics pieces() const { return {}; }
  /// Of the latest pose relative to the first of that part, a right perturbation.
  [[nodiscard]] virtual Eigen::Matrix3d covariance() const = 0;
  /// The latest pose from matching alone, without jumps.
  [[nodiscard]] virtual SE2d T_odom_base() const = 0;
};

/// `q_base_unit` rotates the unit's axes to the robot's, where `options.unit_forward` does not give
/// its mounting.
[[nodiscard]] detail::Owned<LaserSlam> make_laser_slam(
    const SlamNodeOptions& options, const Transform2<frame::Base, frame::Laser>& T_base_laser,
    const std::optional<SO3d>& q_base_unit);

}  // namespace wayfare::ros
