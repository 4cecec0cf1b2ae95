#pragma once

// Simulation of a complete drive: a robot follows a route through a plan, and its sensors are
// recorded. Also kidnapping, by cutting and joining recordings.

#include <functional>
#include <span>
#include <stop_token>
#include <vector>

#include <wayfare/core/time.hpp>
#include <wayfare/sensors/recording.hpp>
#include <wayfare/sim/differential_drive.hpp>
#include <wayfare/sim/lidar_2d.hpp>

namespace wayfare::sim {

enum class HeadingSource { wheels, gyro };

struct RobotParams {
  DriveParams drive;
  WheelParams wheels;
  GyroParams gyro;
  HeadingSource heading = HeadingSource::wheels;  ///< source of the recorded odometry's heading
  Lidar2dParams lidar;
  Transform2<frame::Base, frame::Laser> T_base_laser;
  Duration odometry_period{100'000'000};
  Duration scan_period{200'000'000};
  double radius_m = 0.25;  ///< least distance of the robot to every wall
};

struct SimulatedRun {
  Recording recording;  ///< odometry starts at identity
  Trajectory truth;     ///< in the plan's frame, one pose every drive step
  std::vector<WheelSample> wheels;
  std::vector<GyroSample> gyro;
};

struct SimulationControl {
  std::function<void(double fraction)> progress = {};  ///< called during the simulation of scans
  std::stop_token stop = {};                           ///< on request the call returns `cancelled`
};

/// The same plan, route, parameters and seed give the same bytes. Every sensor draws from its own
/// stream of `rng` and every scan from its own stream of the lidar's, so that changing one sensor
/// does not change the others. Errors: a route that cannot be driven or leads through a wall (with
/// the position), and a plan that is open to the outside as seen from its start.
[[nodiscard]] Result<SimulatedRun> simulate_recording(const FloorPlan& plan,
                                                      std::span<const Eigen::Vector2d> route_m,
                                                      const RobotParams& params, const Rng& rng,
                                                      const SimulationControl& control = {});

/// The measurements in [from, to), at their times.
[[nodiscard]] Recording part_of(const Recording& recording, LogTime from, LogTime to);

/// The robot is kidnapped, without measuring it, from its pose at `from` to that at `to`: the
/// measurements in between are cut out, later times move forward to close the gap, odometry
/// continues and truth jumps; from <= to.
[[nodiscard]] Recording kidnapped(const Recording& recording, LogTime from, LogTime to);

}  // namespace wayfare::sim
