// Scan matching alone in a corridor, the basis of the comparison of radar and LiDAR.

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include <wayfare/sim/worlds.hpp>

#include "localise_by_matching.hpp"

namespace wayfare::examples {
namespace {

// Eight metres straight ahead, with only two walls within the LiDAR's 3.5 m.
Recording straight_drive(std::uint64_t seed) {
  sim::World world = std::move(sim::make_world("corridor_loop", Rng(seed))).value();
  world.route_m = {{1.1, 8.0}, {1.1, 16.0}};
  return sim::simulate_world(world, sim::turtlebot(Rng(seed)), Rng(seed)).value();
}

struct Drive {
  Recording recording;
  std::vector<SyncedStep> steps;

  explicit Drive(std::uint64_t seed)
      : recording(straight_drive(seed)), steps(synchronise(recording, sync_params(recording))) {}

  [[nodiscard]] MatchingRun run(Sensor sensor, const MatchingOptions& options = {}) const {
    auto result = localise_by_matching(steps, recording, sensor,
                                       recording.truth.front().T_map_base.raw(), options);
    EXPECT_TRUE(result.has_value()) << result.error().to_string();
    return result ? std::move(*result) : MatchingRun{};
  }
  // Of the last pose, in the robot's axes.
  [[nodiscard]] Eigen::Vector3d error(const MatchingRun& run) const {
    return run.trajectory.back().T_map_base.raw().minus(
        sim::true_pose_at(recording.truth, run.trajectory.back().time));
  }
};

TEST(Hallway, RadarKeepsItsPlaceWhereLidarSlides) {
  for (const std::uint64_t seed : {21U, 22U}) {
    const Drive drive(seed);
    const Eigen::Vector3d lidar = drive.error(drive.run(Sensor::lidar)),
                          radar = drive.error(drive.run(Sensor::radar));
    EXPECT_GT(std::abs(lidar.x()), 3.0 * std::abs(radar.x()));
    EXPECT_LT(std::abs(radar.x()), 0.25);
    EXPECT_LT(std::abs(lidar.y()), 0.15) << "the walls hold it in the middle";
  }
}

TEST(Hallway, OdometryAloneIsTheWheels) {
  const Drive drive(21);
  SE2d pose = drive.recording.truth.front().T_map_base.raw();
  for (const WheelSample& w : drive.recording.wheels)
    pose = pose.plus(
        {0.5 * (w.left_m + w.right_m), 0.0, (w.right_m - w.left_m) / drive.recording.wheel_base_m});
  const SE2d last = drive.run(Sensor::odometry).trajectory.back().T_map_base.raw();
  EXPECT_LT(last.minus(pose).norm(), 0.02);  // the steps end within one period of the last sample
}

// Widths of the scores around a match: cells within a tenth of the best, along and across.
std::array<double, 2> widths(const ScoreSurface& surface) {
  const auto [low, high] = std::minmax_element(surface.log_score.begin(), surface.log_score.end());
  const double limit = *high - 0.1 * (*high - *low);
  Eigen::Vector2d squares = Eigen::Vector2d::Zero();
  double count = 0.0;
  for (int y = -surface.half_y; y <= surface.half_y; ++y) {
    for (int x = -surface.half_x; x <= surface.half_x; ++x) {
      if (surface.at({{x, y}, 0}) < limit) continue;
      squares += (surface.prior.rotation().inverse() * Eigen::Vector2d(x, y)).cwiseAbs2();
      count += 1.0;
    }
  }
  return {std::sqrt(squares.x() / count), std::sqrt(squares.y() / count)};
}

// The LiDAR's score is a ridge along the corridor; the radar's is a peak.
TEST(Hallway, ScoresAreARidgeForLidarAndAPeakForRadar) {
  const Drive drive(21);
  MatchingOptions options;
  options.surface_at = LogTime::from_seconds(20.0);
  const MatchingRun lidar = drive.run(Sensor::lidar, options),
                    radar = drive.run(Sensor::radar, options);
  ASSERT_TRUE(lidar.surface && radar.surface);
  const auto ridge = widths(*lidar.surface), peak = widths(*radar.surface);
  EXPECT_GT(ridge[0], 5.0 * ridge[1]);
  EXPECT_LT(peak[0], 0.5 * ridge[0]);
  EXPECT_LT(ridge[1], peak[1]) << "across, LiDAR is the sharper of the two";
}

}  // namespace
}  // namespace wayfare::examples
