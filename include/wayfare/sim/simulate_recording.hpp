#pragma once

// A robot on two driven wheels: following of a route, and the samples of its wheels and gyro.
//
// Simulation of a complete drive: a robot follows a route through a plan, and its sensors are
// recorded. Also kidnapping, by cutting and joining recordings.

#include <functional>
#include <span>
#include <stop_token>
#include <vector>

#include <Eigen/Core>

#include <wayfare/core/random.hpp>
#include <wayfare/core/result.hpp>
#include <wayfare/core/time.hpp>
#include <wayfare/sensors/measurements.hpp>
#include <wayfare/sensors/recording.hpp>
#include <wayfare/sensors/trajectory.hpp>
#include <wayfare/sim/floor_plan.hpp>

namespace wayfare::sim {

/// Speeds of a robot that follows a route.
struct DriveParams {
  double max_speed_m_s = 0.9;                 ///< forward, on straights
  double max_turn_rate_rad_s = 1.2;           ///< to either side
  double max_acceleration_m_s2 = 0.6;         ///< also of braking
  double max_turn_acceleration_rad_s2 = 3.0;  ///< of the turn rate
  double heading_gain_per_s = 2.5;            ///< turn rate per radian of heading error
  double waypoint_radius_m = 0.3;             ///< distance at which a waypoint is reached
  Duration step{10'000'000};                  ///< the speeds are constant within a step
  Duration timeout{std::chrono::hours(4)};    ///< of the drive; beyond it drive_route fails
};

/// The true trajectory of a robot that starts at rest on the first waypoint, heading for the
/// second, and follows the rest: one pose every `step`. Errors: fewer than two waypoints, waypoints
/// that are not finite, and a timeout before the last one.
[[nodiscard]] Result<Trajectory> drive_route(std::span<const Eigen::Vector2d> route_m,
                                             const DriveParams& params = {}, LogTime start = {});

/// A part of the floor on which wheels slip more and sink in: they report more than they roll.
struct Carpet {
  Eigen::Vector2d lower_m = Eigen::Vector2d::Zero();  ///< corner with the least x and y, m
  Eigen::Vector2d upper_m = Eigen::Vector2d::Zero();  ///< corner with the greatest x and y, m
  double slip_factor = 3.0;                           ///< of the random slip's standard deviation
  double reported_scale = 1.02;                       ///< metres reported per metre rolled

  /// Whether a point is on it, edges included.
  [[nodiscard]] bool covers(const Eigen::Vector2d& p) const {
    return (p.array() >= lower_m.array()).all() && (p.array() <= upper_m.array()).all();
  }
};

/// Geometry and errors of the wheels.
struct WheelParams {
  double wheel_base_m = 0.4;  ///< distance of the wheels
  double left_scale = 1.0;    ///< metres reported per metre rolled: a wheel of another radius
  double right_scale = 1.0;   ///< of the right wheel
  /// Random slip of each wheel: standard deviation after one metre, growing with the root of the
  /// distance rolled (forward or backward).
  double slip_m_per_sqrt_m = 0.004;
  std::vector<Carpet> carpets = {};  ///< in the truth's frame; the first covering a point applies
};

/// Errors of the gyro.
struct GyroParams {
  double bias_rad_s = 0.0;  ///< constant error of the rate
  /// Standard deviation of the integrated angle after one second, growing with the root of time.
  double angle_random_walk_rad_per_sqrt_s = 0.0;
};

/// One sample every `period`, the first at the start of `truth` (and zero).
[[nodiscard]] std::vector<WheelSample> simulate_wheels(const Trajectory& truth, Duration period,
                                                       const WheelParams& params, Rng& rng);
/// One sample every `period`, the first at the start of `truth` (and zero).
[[nodiscard]] std::vector<GyroSample> simulate_gyro(const Trajectory& truth, Duration period,
                                                    const GyroParams& params, Rng& rng);

/// Dead reckoning from identity: the mean of the two wheels along an arc with the heading change
/// (right - left) / wheel_base.
[[nodiscard]] std::vector<OdometrySample> dead_reckon(std::span<const WheelSample> wheels,
                                                      double wheel_base_m);
/// The same with the heading change from the gyro; both series must have the same times.
[[nodiscard]] std::vector<OdometrySample> dead_reckon(std::span<const WheelSample> wheels,
                                                      std::span<const GyroSample> gyro);

/// The pose at `time`, along the constant-twist path between the neighbours in `trajectory` (in
/// order of time, not empty); constant before the first and after the last.
[[nodiscard]] SE2d true_pose_at(const Trajectory& trajectory, LogTime time);

/// Where the heading change of odometry is from.
enum class HeadingSource {
  wheels,  ///< difference of the wheels
  gyro,    ///< its mean rates
};

/// Drive and sensors of a simulated robot.
struct RobotParams {
  DriveParams drive;                              ///< speeds
  WheelParams wheels;                             ///< errors of the wheels
  GyroParams gyro;                                ///< errors of the gyro
  HeadingSource heading = HeadingSource::wheels;  ///< source of the recorded odometry's heading
  Lidar2dParams lidar;                            ///< range finder
  Transform2<frame::Base, frame::Laser> T_base_laser;  ///< its mounting
  Duration odometry_period{100'000'000};               ///< of wheels, gyro and odometry
  Duration scan_period{200'000'000};                   ///< between sweeps
  double radius_m = 0.25;  ///< least distance of the robot to every wall
};

/// A recording and the truth behind it.
struct SimulatedRun {
  Recording recording;              ///< odometry starts at identity
  Trajectory truth;                 ///< in the plan's frame, one pose every drive step
  std::vector<WheelSample> wheels;  ///< every odometry_period
  std::vector<GyroSample> gyro;     ///< every odometry_period
};

/// Progress and cancellation.
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
