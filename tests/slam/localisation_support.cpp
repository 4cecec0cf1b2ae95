#include "localisation_support.hpp"

#include <utility>

#include <gtest/gtest.h>

#include <wayfare/sensors/trajectory.hpp>
#include <wayfare/sim/floor_plan.hpp>
#include <wayfare/sim/simulate_recording.hpp>

namespace wayfare {

Place make_place(const char* text, std::uint64_t seed) {
  const auto planned = sim::read_plan(text);
  EXPECT_TRUE(planned) << planned.error().message;
  sim::RobotParams robot;
  robot.drive.max_speed_m_s = 0.5;
  robot.wheels.right_scale = 1.002;
  robot.lidar = sim::full_circle(90);
  robot.lidar.max_range_m = 6.0;
  robot.T_base_laser = Transform2<frame::Base, frame::Laser>(SE2d(0.1, 0.0, 0.2_rad));
  auto run = sim::simulate_recording(planned->plan, planned->route_m, robot, Rng(seed));
  EXPECT_TRUE(run) << run.error().message;
  const auto grid = sim::map_of_plan(planned->plan, planned->route_m.front());
  EXPECT_TRUE(grid) << grid.error().message;
  const auto map = LocalisationMap::make(*grid);
  EXPECT_TRUE(map) << map.error().message;
  run->recording.truth = std::move(run->truth);
  return {std::move(run->recording), *grid, *map};
}

LocalisationOptions quick() {
  LocalisationOptions options;
  options.max_particles = 4000;
  return options;
}

Gaussian<SE2d> known_start(const Recording& recording) {
  return {recording.truth.front().T_map_base.raw(),
          Eigen::Vector3d(0.01, 0.01, 0.0025).asDiagonal()};
}

LocalisationRun run(const Recording& recording, const Place& place,
                    const LocalisationOptions& options, const std::optional<Gaussian<SE2d>>& start,
                    std::uint64_t seed) {
  auto result = run_localisation(recording, place.map, options, seed, start);
  EXPECT_TRUE(result) << result.error().message;
  return *std::move(result);
}

Eigen::Vector3d error_of(const LocalisationOutcome& o, const Recording& recording) {
  return o.T_map_base.mean.minus(*pose_at(recording.truth, o.time));
}

void expect_found(const LocalisationRun& result, const Recording& recording) {
  const LocalisationOutcome& last = result.outcomes.back();
  EXPECT_TRUE(last.converged) << last.clusters << " clusters, mass " << last.mass;
  EXPECT_LT(error_of(last, recording).head<2>().norm(), 0.15);
}

void expect_same(const LocalisationRun& a, const LocalisationRun& b) {
  ASSERT_EQ(a.outcomes.size(), b.outcomes.size());
  for (std::size_t i = 0; i < a.outcomes.size(); ++i) {
    const LocalisationOutcome &x = a.outcomes[i], &y = b.outcomes[i];
    ASSERT_EQ(x.T_map_base.mean.translation(), y.T_map_base.mean.translation()) << "scan " << i;
    ASSERT_EQ(x.T_map_base.covariance, y.T_map_base.covariance) << "scan " << i;
    ASSERT_EQ(x.particles, y.particles) << "scan " << i;
    ASSERT_EQ(x.mass, y.mass) << "scan " << i;
  }
}

}  // namespace wayfare
