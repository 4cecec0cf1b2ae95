#pragma once

// Trajectories of robots and vehicles, and their poses at any time.

#include <algorithm>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include <wayfare/core/frame.hpp>
#include <wayfare/core/geodesy.hpp>
#include <wayfare/core/se2.hpp>
#include <wayfare/core/se3.hpp>
#include <wayfare/core/time.hpp>

namespace wayfare {

/// Position, velocity and attitude of a vehicle, estimated or reference. `q_nb` rotates body
/// (forward-right-down) to local level (north-east-down).
struct NavState {
  LogTime time;                                                ///< of the state
  Geodetic position;                                           ///< WGS-84
  Eigen::Vector3d velocity_ned_mps = Eigen::Vector3d::Zero();  ///< m/s over the Earth
  SO3d q_nb;                                                   ///< body to local level
};

using NavTrajectory = std::vector<NavState>;  ///< in order of time

/// The robot's pose by dead reckoning.
struct OdometrySample {
  LogTime time;                                      ///< of the sample
  Transform2<frame::Odom, frame::Base> T_odom_base;  ///< continuous, drifting
};

/// A time-stamped pose of an estimated or reference trajectory.
struct StampedPose {
  LogTime time;                                    ///< of the pose
  Transform2<frame::Map, frame::Base> T_map_base;  ///< of the robot
};

using Trajectory = std::vector<StampedPose>;  ///< in order of time

/// Limits of interpolation in a trajectory.
struct GapLimit {
  /// No pose between samples further apart than this …
  Duration largest_gap = Duration::max();
  /// … except at times this close to one of them.
  Duration near = Duration::zero();
};

/// The pose at `time`, along the constant-twist path between the two samples around it; nothing
/// outside the trajectory or in a gap of it. `trajectory` is in order of time.
[[nodiscard]] inline std::optional<SE2d> pose_at(std::span<const StampedPose> trajectory,
                                                 LogTime time, const GapLimit& limit = {}) {
  const auto after =
      std::lower_bound(trajectory.begin(), trajectory.end(), time,
                       [](const StampedPose& sample, LogTime t) { return sample.time < t; });
  if (after == trajectory.end()) return std::nullopt;
  if (after->time == time) return after->T_map_base.raw();
  if (after == trajectory.begin()) return std::nullopt;
  const StampedPose& before = *(after - 1);
  const Duration gap = after->time - before.time;
  const Duration nearest = std::min(time - before.time, after->time - time);
  if (gap > limit.largest_gap && nearest > limit.near) return std::nullopt;
  const double u = to_seconds(time - before.time) / to_seconds(gap);
  return interpolate(before.T_map_base.raw(), after->T_map_base.raw(), u);
}

/// Odometry as a trajectory, e.g. for evaluation.
[[nodiscard]] inline Trajectory as_trajectory(std::span<const OdometrySample> odometry) {
  Trajectory result;
  result.reserve(odometry.size());
  for (const OdometrySample& sample : odometry)
    result.push_back({sample.time, Transform2<frame::Map, frame::Base>(sample.T_odom_base.raw())});
  return result;
}

}  // namespace wayfare
