#include <wayfare/sim/floor_plan.hpp>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace wayfare::sim {
namespace {

double measure(double true_range_m, const Lidar2dParams& params, Rng& rng) {
  // Both numbers are drawn for every beam, so that one beam does not shift the noise of others.
  const double noise_m = params.range_noise_m * rng.normal();
  const bool missed = rng.uniform() < params.missed_return;
  if (missed || !(true_range_m < params.max_range_m)) return params.max_range_m;
  double range_m = std::max(0.0, true_range_m + noise_m);
  if (params.resolution_m > 0.0)
    range_m = std::round(range_m / params.resolution_m) * params.resolution_m;
  return std::min(range_m, params.max_range_m);
}

}  // namespace

Lidar2dParams full_circle(std::size_t beams) {
  WAYFARE_EXPECTS(beams > 0, "a lidar has beams");
  Lidar2dParams params;
  params.beams = beams;
  params.first_bearing = Angle::degrees(-180.0);
  params.bearing_step = Angle::degrees(360.0 / static_cast<double>(beams));
  return params;
}

LaserScan simulate_scan(const FloorPlan& plan, const std::function<SE2d(LogTime)>& T_plan_laser,
                        LogTime time, const Lidar2dParams& params, Rng& rng) {
  LaserScan scan{time,
                 params.first_bearing,
                 params.bearing_step,
                 static_cast<float>(params.min_range_m),
                 static_cast<float>(params.max_range_m),
                 {}};
  scan.ranges_m.reserve(params.beams);
  const double last = static_cast<double>(std::max<std::size_t>(params.beams, 2) - 1);
  SE2d pose = T_plan_laser(time);
  for (std::size_t i = 0; i < params.beams; ++i) {
    if (params.sweep > Duration::zero())
      pose = T_plan_laser(time +
                          from_seconds(to_seconds(params.sweep) * static_cast<double>(i) / last));
    const double bearing = scan.bearing(i).radians();
    const Eigen::Vector2d beam =
        pose.rotation() * Eigen::Vector2d(std::cos(bearing), std::sin(bearing));
    const double range_m = plan.cast(pose.translation(), beam, params.max_range_m);
    scan.ranges_m.push_back(static_cast<float>(measure(range_m, params, rng)));
  }
  return scan;
}

}  // namespace wayfare::sim
