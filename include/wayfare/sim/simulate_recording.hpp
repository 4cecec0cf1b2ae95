#pragma once

// A whole run: a robot drives a route through a plan, and its sensors are recorded.

// Recordings cut and joined: what a robot that is lifted and put down elsewhere records.

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
  HeadingSource heading = HeadingSource::wheels;  ///< what the recorded odometry turns by
  Lidar2dParams lidar;
  Transform2<frame::Base, frame::Laser> T_base_laser;
  Duration odometry_period{100'000'000};
  Duration scan_period{200'000'000};
  double radius_m = 0.25;  ///< the robot must keep this far from every wall
};

struct SimulatedRun {
  Recording recording;  ///< odometry starts at identity
  Trajectory truth;     ///< in the plan's frame, one pose every drive step
  std::vector<WheelSample> wheels;
  std::vector<GyroSample> gyro;
};

struct SimulationControl {
  std::function<void(double fraction)> progress = {};  ///< called as the scans are made
  std::stop_token stop = {};                           ///< on request the call ends as `cancelled`
};

/// The same plan, route, parameters and seed give the same bytes. Every sensor draws from its own
/// stream of `rng` and every scan from its own stream of the lidar's, so that changing one sensor
/// leaves the others as they were. Fails where the route cannot be driven or leads through a wall
/// (the place is named), and where the plan is open to the outside as seen from its start.
[[nodiscard]] Result<SimulatedRun> simulate_recording(const FloorPlan& plan,
                                                      std::span<const Eigen::Vector2d> route_m,
                                                      const RobotParams& params, const Rng& rng,
                                                      const SimulationControl& control = {});

/// What was recorded in [from, to), at the times it was.
[[nodiscard]] Recording part_of(const Recording& recording, LogTime from, LogTime to);

/// The robot is carried, without noticing, from where it was at `from` to where it was at `to`:
/// what lies between is cut out, later times move forward to close the gap, odometry goes on as if
/// nothing had happened and truth jumps; from <= to.
[[nodiscard]] Recording kidnapped(const Recording& recording, LogTime from, LogTime to);

}  // namespace wayfare::sim
