#pragma once

// Walkers with an inertial unit on each foot, or with one and a range finder on the head: bob,
// sway, tilt and glances.

#include <span>
#include <vector>

#include <Eigen/Core>

#include <wayfare/core/random.hpp>
#include <wayfare/core/result.hpp>
#include <wayfare/core/se3.hpp>
#include <wayfare/inertial/imu_noise.hpp>
#include <wayfare/sensors/measurements.hpp>
#include <wayfare/sensors/scans.hpp>
#include <wayfare/sim/floor_plan.hpp>

namespace wayfare::sim {

/// Stairs: strides of two steps each, of which `rise_m` is the height (negative: downward) and
/// `tread_m` the horizontal length.
struct StairFlight {
  int first = 0;         ///< stride of the walk
  int strides = 5;       ///< strides on the stairs
  double rise_m = 0.34,  ///< of a stride
      tread_m = 0.58;    ///< of a stride
};

/// A walk in strides: each foot alternates swing and stance, the right one half a stride later.
struct FeetPlan {
  double rate_hz = 100.0;     ///< of the samples
  int strides = 60;           ///< of each foot
  double rest_s = 3.0;        ///< both feet together, at the start and the end
  double swing_s = 0.45,      ///< of a foot in the air
      stance_s = 0.65;        ///< of a foot on the floor
  double stride_m = 1.3,      ///< length on level floor
      lift_m = 0.1;           ///< height of a swing
  double width_m = 0.2;       ///< from the left foot to the right
  double pitch_rad = 0.7;     ///< toe down at the highest point of a swing
  double turn_rad = 0.0;      ///< heading change per stride; counter-clockwise
  double sway_radps = 0.015;  ///< greatest rate of a foot in stance, which is never exactly at rest
  std::vector<StairFlight> stairs;  ///< elsewhere the floor is level
};

/// One foot: samples and its position at each, relative to its start; axes x forward, y left, z up
/// at the start.
struct FootTruth {
  std::vector<ImuSample> samples;         ///< of the unit on the foot
  std::vector<Eigen::Vector3d> position;  ///< at each sample, m
};

/// Both feet of a walk.
struct FeetTruth {
  FootTruth left,                   ///< of the unit on it
      right;                        ///< of the unit on it
  Eigen::Vector3d right_from_left;  ///< at the start
  double length_m = 0.0;            ///< of the path
};

/// A swing is a smooth step in time (10u³ − 15u⁴ + 6u⁵) forward with a bump (64u³(1 − u)³) upward;
/// each unit has its own noise. At most ten million samples.
[[nodiscard]] FeetTruth simulate_feet(const FeetPlan& plan, const ImuNoise& noise, const Rng& rng);

/// Errors of a barometer: white noise of a reading, and a random walk of the pressure.
struct BarometerNoise {
  double white_Pa = 2.0;  ///< standard deviation of a reading
  double drift_Pa = 0.3;  ///< random walk of the pressure, Pa/√s
};
/// Pressure at heights that follow each other by `dt_s`, from 101325 Pa at height zero.
[[nodiscard]] std::vector<double> simulate_pressure(std::span<const double> heights_m, double dt_s,
                                                    const BarometerNoise& noise, Rng& rng);

/// The motion is that of ten walks recorded by a unit on the head: |a| varies by 1.9 to 2.9 m/s² at
/// 1.6 to 1.95 steps per second, pitch by 1.7 to 3.9°, roll by 1.1 to 2.3°, glances by 10 to 20°;
/// the mounting is off by 2 to 5°.
struct HeadWalkParams {
  double speed_m_s = 1.2;                      ///< along the path
  double step_m = 0.66;                        ///< length of a step
  double height_m = 1.7;                       ///< of the head above the floor
  double bob_m = 0.027;                        ///< amplitude, once per step
  double sway_m = 0.02;                        ///< amplitude, once in two steps
  Angle glance = Angle::degrees(10),           ///< σ of the yaw about the path
      pitch = Angle::degrees(2.3),             ///< σ of the pitch
      roll = Angle::degrees(1.4);              ///< σ of the roll
  Angle nod = Angle::degrees(0.9);             ///< amplitude of the pitch, once per step
  Angle mounting_sigma = Angle::degrees(3.5);  ///< mounting error, standard deviation per axis
  double corner_m = 0.8;  ///< the path is rounded over this distance before and after a corner
  double rest_s = 4.0;    ///< at rest before and after
};

/// The head's pose at any time from 0 to `duration_s`; axes x forward, y left, z up.
class HeadWalk {
 public:
  /// Pose of the head.
  struct Pose {
    SO3d q_world_head;           ///< x forward, y left, z up
    Eigen::Vector3d position_m;  ///< m, above the plan
  };

  /// Along the waypoints `route_m`, two or more distinct ones; the other properties of the walk are
  /// random.
  HeadWalk(std::vector<Eigen::Vector2d> route_m, const HeadWalkParams& params, Rng rng);

  /// Duration of the walk with its rests.
  [[nodiscard]] double duration_s() const { return duration_s_; }
  /// Length of the rounded path.
  [[nodiscard]] double path_length_m() const { return along_.back(); }
  /// At a time from 0 to `duration_s`.
  [[nodiscard]] Pose at(double time_s) const;

  /// Errors of the unit.
  struct UnitNoise {
    double gyro_radps = 0.002,                          ///< of the rate
        accel_mps2 = 0.05;                              ///< of the specific force, per sample
    Angle gyro_bias_per_second = Angle::degrees(0.05);  ///< standard deviation, constant
    double accel_bias_mps2 = 0.0;                       ///< the same
  };
  /// Nine-axis samples without a magnetic field, from the pose's derivatives.
  [[nodiscard]] MargRecording unit(double rate_hz, const UnitNoise& noise, Rng& rng) const;

 private:
  struct Wave {
    double amplitude, rate, phase;
  };
  static std::vector<Wave> waves(double sigma, Rng& rng);
  static double sum(const std::vector<Wave>& waves, double time_s);
  [[nodiscard]] double travelled(double time_s) const;
  [[nodiscard]] Eigen::Vector2d on_route(double s) const;
  [[nodiscard]] Eigen::Vector2d rounded(double s) const;

  HeadWalkParams p_;
  std::vector<Eigen::Vector2d> route_m_;
  std::vector<double> along_;  // path length up to each waypoint
  std::vector<Wave> yaw_, pitch_, roll_;
  SO3d q_head_unit_;
  double duration_s_ = 0.0, phase_ = 0.0;
};

/// A range finder rotating in the head's x-y plane; walls are upright from floor to ceiling.
struct HeadLidarParams {
  int beams = 360;            ///< over the full circle
  double max_range_m = 12.0,  ///< farther walls give no return
      min_range_m = 0.15;     ///< nearer walls give no return
  double noise_m = 0.01,      ///< σ at distance zero
      noise_per_m = 0.004;    ///< and its growth with the distance
  double ceiling_m = 2.7;     ///< of the rooms, above the floor
  Duration sweep{0};          ///< time from the first beam to the last: 182 ms at 5.5 Hz
};
/// All beams at one instant.
[[nodiscard]] LaserScan scan_from_head(const FloorPlan& plan, const HeadWalk::Pose& head,
                                       LogTime time, const HeadLidarParams& params, Rng& rng);
/// A sweep, with `time` in the middle: each beam from the head's pose at its own time.
[[nodiscard]] LaserScan sweep_from_head(const FloorPlan& plan, const HeadWalk& walk, LogTime time,
                                        const HeadLidarParams& params, Rng& rng);

}  // namespace wayfare::sim
