#pragma once

#include <cstddef>
#include <functional>

#include <wayfare/core/random.hpp>
#include <wayfare/core/se2.hpp>
#include <wayfare/sensors/laser_scan.hpp>
#include <wayfare/sim/floor_plan.hpp>

namespace wayfare::sim {

/// A planar range finder. The default resembles a SICK LMS: 180 beams over 180°.
struct Lidar2dParams {
  std::size_t beams = 180;
  Angle first_bearing = Angle::degrees(-90.0);
  Angle bearing_step = Angle::degrees(1.0);
  double min_range_m = 0.05;
  double max_range_m = 30.0;
  double range_noise_m = 0.01;   ///< standard deviation, the same at every distance
  double resolution_m = 0.001;   ///< ranges are rounded to multiples of it; 0: not rounded
  double missed_return = 0.002;  ///< probability of no return from a wall
  Duration sweep{0};             ///< time from the first beam to the last
};

/// A sensor with a full field of view: `beams` equal steps over 360°.
[[nodiscard]] Lidar2dParams full_circle(std::size_t beams);

/// The sweep that starts at `time`; `T_plan_laser(t)` is the laser's pose during it. A beam without
/// return (nothing in range, or missed) reads `max_range_m`.
[[nodiscard]] LaserScan simulate_scan(const FloorPlan& plan,
                                      const std::function<SE2d(LogTime)>& T_plan_laser,
                                      LogTime time, const Lidar2dParams& params, Rng& rng);

}  // namespace wayfare::sim
