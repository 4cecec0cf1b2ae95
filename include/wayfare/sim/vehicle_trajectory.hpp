#pragma once

// True motion of a road vehicle, driven through waypoints or along a recorded solution, and the
// measurements of an inertial unit on it with configurable errors.

#include <span>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include <wayfare/core/random.hpp>
#include <wayfare/core/result.hpp>
#include <wayfare/inertial/imu_noise.hpp>
#include <wayfare/sensors/measurements.hpp>
#include <wayfare/sensors/trajectory.hpp>
#include <wayfare/sim/detail/smooth_curve.hpp>

namespace wayfare::sim {

/// A position on the drive, from its origin.
struct Waypoint {
  double north_m = 0.0;   ///< from the origin
  double east_m = 0.0;    ///< from the origin
  double height_m = 0.0;  ///< above the ellipsoid
  double stop_s = 0.0;    ///< time at rest there; at a corner, before it
};

/// What the vehicle and its driver do at most.
struct VehicleLimits {
  double speed_mps = 22.0;                 ///< highest speed
  double acceleration_mps2 = 2.0;          ///< highest, forward
  double braking_mps2 = 2.5;               ///< highest, in front of corners and stops
  double lateral_acceleration_mps2 = 2.5;  ///< highest: the speed in corners
  double turn_rate_radps = 0.5;            ///< highest, in tight corners
  double turn_radius_m = 15.0;             ///< the smallest; corners are rounded, not reached
  /// Rise time of the acceleration, s: bounds the jerk.
  double build_up_s = 0.8;
  /// Roll of the body outward per lateral acceleration, rad/(m/s²).
  double roll_per_lateral = 0.006;
};

/// Fit to a recorded solution: standard deviations of its noise, and of the vehicle's jerk.
struct TrackFit {
  double position_sigma_m = 0.005;   ///< of the solution, each axis
  double velocity_sigma_mps = 0.05;  ///< of the solution, each axis
  /// Velocities are valid this time before their stamp, s: half the interval for receivers that
  /// give the mean over it.
  double velocity_late_s = 0.0;
  double jerk_sigma_mps3 = 3.0;  ///< of the vehicle, each axis; smaller: smoother
  double knot_spacing_s = 0.25;  ///< of the splines
  /// Below this speed, m/s, the course does not determine the heading.
  double min_course_speed_mps = 1.0;
  bool attitude_from_course = true;  ///< else the solution's own attitude
};

/// State of the vehicle and the ideal measurement of a unit aligned with its body: specific force,
/// and rate relative to inertial space.
struct VehicleMotion {
  NavState nav;                                                   ///< of the vehicle
  Eigen::Vector3d specific_force_mps2 = Eigen::Vector3d::Zero();  ///< m/s², body axes
  Eigen::Vector3d angular_rate_radps = Eigen::Vector3d::Zero();   ///< rad/s, body axes
};

/// A smooth trajectory: position and attitude each with continuous second derivative.
class VehicleTrajectory {
 public:
  /// Both curves over seconds since `start`: north, east, down in the local level of `origin`;
  /// roll, pitch and yaw (not wrapped) relative to the local level at the position itself, radians.
  VehicleTrajectory(const Geodetic& origin, LogTime start, SmoothCurve position,
                    SmoothCurve attitude)
      : origin_(origin),
        start_(start),
        position_(std::move(position)),
        attitude_(std::move(attitude)) {}

  /// Start of the drive.
  [[nodiscard]] LogTime begin() const { return start_; }
  /// End of the drive.
  [[nodiscard]] LogTime end() const { return start_ + from_seconds(position_.end_s()); }
  /// At rest before begin() and after end().
  [[nodiscard]] NavState state(LogTime time) const { return motion(time).nav; }
  /// At rest before begin() and after end().
  [[nodiscard]] VehicleMotion motion(LogTime time) const;

 private:
  Geodetic origin_;
  LogTime start_;
  SmoothCurve position_, attitude_;
};

/// Starts and ends at rest; corners are rounded with continuous curvature, speed is as high as the
/// limits allow. Errors: fewer than two distinct waypoints, values that are not finite, a
/// negative time at rest, heights beyond ± 1000 km, heading changes of more than 170°, more than
/// 2000 km or 111 hours.
[[nodiscard]] Result<VehicleTrajectory> drive_waypoints(const Geodetic& origin,
                                                        std::span<const Waypoint> waypoints,
                                                        const VehicleLimits& limits = {},
                                                        LogTime start = {});

/// Follows a recorded solution in order of time. The vehicle is assumed to drive forward and to
/// keep its heading at rest. Errors: fewer than four states, states that are not finite or not in
/// order of time, and more than five million knots.
[[nodiscard]] Result<VehicleTrajectory> follow_solution(std::span<const NavState> solution,
                                                        const TrackFit& fit = {});

/// A drive through streets with turns to both sides, hills and stops at lights, 310 s and 4.5 km
/// long, as the test drive of Zhang 2020.
[[nodiscard]] VehicleTrajectory demo_drive(LogTime start = {});

/// Laps of a block of 900 m by 800 m, five minutes each, with hills and stops; smooth enough for a
/// unit at 10 Hz.
[[nodiscard]] VehicleTrajectory round_drive(int rounds, LogTime start = {});

/// Position and velocity of a point fixed to the body, in Earth-fixed axes.
struct EcefMotion {
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();    ///< Earth-fixed
  Eigen::Vector3d velocity_mps = Eigen::Vector3d::Zero();  ///< Earth-fixed, over the Earth
};
/// Of a point at `lever_arm_body_m`, m, body axes.
[[nodiscard]] EcefMotion ecef_motion(const VehicleMotion& motion,
                                     const Eigen::Vector3d& lever_arm_body_m);

/// Defaults: 100 Hz, aligned with the body, errors of an automotive MEMS unit.
struct ImuParams {
  ImuNoise noise;               ///< errors of the unit
  Duration period{10'000'000};  ///< between samples
  SO3d q_body_imu;              ///< mounting: rotates the unit's axes to the body's
  /// Each sample is the mean since the previous one, as of an integrating unit; else the instant's
  /// value.
  bool mean_of_period = false;
};

/// Errors of a unit at one instant, in its own axes, besides white noise.
struct ImuErrors {
  Eigen::Vector3d gyro_bias_radps = Eigen::Vector3d::Zero();  ///< rad/s
  Eigen::Vector3d accel_bias_mps2 = Eigen::Vector3d::Zero();  ///< m/s²
  Eigen::Vector3d gyro_scale = Eigen::Vector3d::Zero();       ///< relative
  Eigen::Vector3d accel_scale = Eigen::Vector3d::Zero();      ///< relative
};

/// Readings of a drive and the truth behind them.
struct SimulatedImu {
  std::vector<ImuSample> samples;  ///< in order of time
  std::vector<ImuErrors> errors;   ///< one per sample
};

/// Errors over time: four Gauss-Markov processes per unit, started in their stationary distribution
/// and discretised exactly, n ← e^(−T/τ) n + σ√(1 − e^(−2T/τ)) w.
class ImuErrorProcess {
 public:
  /// Draws the errors of the start.
  ImuErrorProcess(const ImuNoise& noise, Rng& rng);
  /// Errors `seconds` later.
  void step(double seconds, Rng& rng);
  /// (1 + scale) ∘ `truth` + bias + white noise whose standard deviation is its density over
  /// √`seconds`; all in the unit's axes.
  [[nodiscard]] ImuSample measure(const ImuSample& truth, double seconds, Rng& rng) const;
  /// Errors now.
  [[nodiscard]] const ImuErrors& errors() const { return errors_; }

 private:
  ImuNoise noise_;
  ImuErrors errors_;
};

/// A unit on the vehicle, sample by sample, by ImuErrorProcess. The trajectory must outlive it.
class SimulatedUnit {
 public:
  /// The first sample is at trajectory.begin().
  SimulatedUnit(const VehicleTrajectory& trajectory, const ImuParams& params, const Rng& rng);
  /// False at the end of the trajectory.
  [[nodiscard]] bool read(ImuSample& sample);
  /// Of the last sample.
  [[nodiscard]] const ImuErrors& errors() const { return process_.errors(); }

 private:
  const VehicleTrajectory& trajectory_;
  ImuParams params_;
  Rng rng_;
  ImuErrorProcess process_;
  LogTime next_;
};

/// All samples of a trajectory.
[[nodiscard]] SimulatedImu simulate_imu(const VehicleTrajectory& trajectory,
                                        const ImuParams& params, const Rng& rng);

/// No error of any kind.
[[nodiscard]] ImuNoise perfect_imu();

/// Wheels of an axle that does not steer.
struct WheelSpeedParams {
  Duration period{100'000'000};  ///< between readings
  double scale = 0.01;           ///< relative error of the speed
  double sigma_mps = 0.03;       ///< white noise
  double resolution_mps = 0.02;  ///< readings are multiples of it; zero: any number
  /// From the unit to the middle of the axle, body axes, m.
  Eigen::Vector3d lever_arm_m = Eigen::Vector3d::Zero();
  double slips_per_hour = 0.0;      ///< rate at which wheels spin or lock
  double mean_slip_s = 1.0;         ///< exponentially distributed duration
  double mean_slip_fraction = 0.2;  ///< of the speed, exponentially distributed, to either side
};

/// Readings of a drive from trajectory.begin() on, and which of them slip.
struct SimulatedWheelSpeeds {
  std::vector<WheelSpeed> readings;  ///< in order of time
  std::vector<bool> slips;           ///< one for each reading
};
/// Forward speed of the axle with the errors of `params`.
[[nodiscard]] SimulatedWheelSpeeds simulate_wheel_speeds(const VehicleTrajectory& trajectory,
                                                         const WheelSpeedParams& params,
                                                         const Rng& rng);

}  // namespace wayfare::sim
