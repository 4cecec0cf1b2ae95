#include "heading_walks.hpp"

#include <cmath>

#include <wayfare/pedestrian/pedestrian.hpp>
#include <wayfare/slam/pedestrian_slam.hpp>

#include "recorded_walk.hpp"

namespace wayfare::examples {
namespace {

/// Headings are relative to the first scan, both in the map and by the gyro.
HeadingErrors heading_errors(const RecordedWalk& recorded, const PedestrianSlamOptions& options) {
  PedestrianSlam slam(options);
  double squares = 0.0, normalised = 0.0, first = 0.0;
  std::size_t count = 0;
  auto reading = recorded.unit.begin();
  for (std::size_t i = 0; i < recorded.scans.size(); ++i) {
    const LaserScan& scan = recorded.scans[i];
    for (; reading != recorded.unit.end() && reading->time <= scan.end_time(); ++reading)
      slam.add(*reading);
    if (!slam.add_scan(scan)) continue;
    const auto& ahrs = slam.pedestrian().ahrs();
    const Eigen::Vector3d axis = ahrs.q_world_body() * options.pedestrian.forward;
    const double offset =
        std::atan2(axis.y(), axis.x()) - recorded.truth[i].T_map_base.raw().heading().radians();
    if (i == 0) first = offset;
    const double error = wrap_to_pi(offset - first);
    const double variance = ahrs.heading_variance();
    if (i == 0 || !(variance > 0.0)) continue;
    squares += error * error;
    normalised += error * error / variance;
    ++count;
  }
  (void)slam.finish();
  const auto n = static_cast<double>(count);
  return {rmse_m(slam.slam().trajectory(), recorded.truth),
          Angle::radians(std::sqrt(squares / n)).degrees(), normalised / n};
}

}  // namespace

const std::vector<std::string>& heading_methods() {
  static const std::vector<std::string> names = {"the steps' direction", "the filter"};
  return names;
}

std::vector<HeadingErrors> follow_headings(const Walk& walk, std::uint64_t seed, Angle gyro_bias) {
  sim::HeadWalk::UnitNoise noise;
  noise.gyro_bias_per_second = gyro_bias;
  const SimulatedWalk simulated = simulate_walk(walk, seed, noise);
  PedestrianSlamOptions options;
  options.pedestrian = head_pedestrian(simulated.step_m);
  // The filter knows if the unit is worse than that of the study.
  constexpr double kStudyBias_deg = 0.05;
  if (gyro_bias.degrees() > kStudyBias_deg)
    options.pedestrian.ahrs.bias_sigma = gyro_bias.radians();
  options.heading = false;
  const HeadingErrors outside = heading_errors(simulated.recorded, options);
  options.heading = true;
  return {outside, heading_errors(simulated.recorded, options)};
}

}  // namespace wayfare::examples
