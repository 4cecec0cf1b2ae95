#pragma once

// A walker with an inertial unit on each foot.

#include <vector>

#include <Eigen/Core>

#include <wayfare/core/random.hpp>
#include <wayfare/inertial/imu_noise.hpp>
#include <wayfare/sensors/imu.hpp>

namespace wayfare::sim {

/// A walk in strides: each foot alternates swing and stance, the right one half a stride later.
struct FeetPlan {
  double rate_hz = 100.0;
  int strides = 60;
  double rest_s = 3.0;  ///< both feet together, at the start and the end
  double swing_s = 0.45, stance_s = 0.65;
  double stride_m = 1.3, lift_m = 0.1;
  double width_m = 0.2;       ///< from the left foot to the right
  double pitch_rad = 0.7;     ///< toe down at the highest point of a swing
  double turn_rad = 0.0;      ///< heading change per stride; counter-clockwise
  double sway_radps = 0.015;  ///< greatest rate of a foot in stance, which is never exactly at rest
};

/// One foot: samples and its position at each, relative to its start; axes x forward, y left, z up
/// at the start.
struct FootTruth {
  std::vector<ImuSample> samples;
  std::vector<Eigen::Vector3d> position;
};

struct FeetTruth {
  FootTruth left, right;
  Eigen::Vector3d right_from_left;  ///< at the start
  double length_m = 0.0;            ///< of the path
};

/// A swing is a smooth step in time (10u³ − 15u⁴ + 6u⁵) forward with a bump (64u³(1 − u)³) upward;
/// each unit has its own noise.
[[nodiscard]] FeetTruth simulate_feet(const FeetPlan& plan, const ImuNoise& noise, const Rng& rng);

}  // namespace wayfare::sim
