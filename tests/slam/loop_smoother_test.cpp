#include "slam/radar_slam/loop_smoother.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include <wayfare/sim/floor_plan.hpp>

namespace wayfare {
namespace {

/// Corridors around a block, 10 m × 8 m, with niches at irregular distances.
sim::FloorPlan ring() {
  std::vector<sim::Segment> walls;
  const auto add = [&](const Eigen::Vector2d& lower, const Eigen::Vector2d& upper) {
    const Eigen::Vector2d right(upper.x(), lower.y()), left(lower.x(), upper.y());
    walls.push_back({lower, right});
    walls.push_back({right, upper});
    walls.push_back({upper, left});
    walls.push_back({left, lower});
  };
  add({0.0, 0.0}, {10.0, 8.0});
  add({2.0, 2.0}, {8.0, 6.0});
  for (const double x : {2.7, 4.4, 7.5}) add({x, 0.0}, {x + 0.4, 0.2});
  for (const double y : {3.1, 4.0, 5.5}) add({9.7, y}, {10.0, y + 0.3});
  for (const double x : {1.4, 5.2}) add({x, 7.8}, {x + 0.5, 8.0});
  return sim::FloorPlan::from_segments(std::move(walls)).value();
}

/// Once around the block and on to `end_m` of the first side, 10 cm a pose.
std::vector<SE2d> around(double end_m) {
  const std::vector<Eigen::Vector2d> corners{{1.0, 1.0}, {9.0, 1.0}, {9.0, 7.0},
                                             {1.0, 7.0}, {1.0, 1.0}, {1.0 + end_m, 1.0}};
  std::vector<SE2d> poses;
  for (std::size_t i = 1; i < corners.size(); ++i) {
    const Eigen::Vector2d leg = corners[i] - corners[i - 1];
    const SO2d heading(Angle::radians(std::atan2(leg.y(), leg.x())));
    for (double d = 0.0; d < leg.norm(); d += 0.1)
      poses.emplace_back(Eigen::Vector2d(corners[i - 1] + d * leg.normalized()), heading);
  }
  return poses;
}

/// The latest smoothed path of a drive whose heading drifts, and the truth; empty without loop.
struct SmoothedDrive {
  std::vector<SE2d> truth;
  Trajectory drifted, smoothed;
};
SmoothedDrive smoothed_drive(double end_m, const RadarSlamOptions& options) {
  SmoothedDrive drive{around(end_m), {}, {}};
  const sim::FloorPlan plan = ring();
  sim::Lidar2dParams lidar = sim::full_circle(360);
  lidar.max_range_m = 3.5;
  LoopSmoother smoother(options);
  Rng rng(5);
  const SE2d origin = drive.truth.front();
  SE2d pose;
  drive.drifted.push_back({LogTime(), MapPose(pose)});
  for (std::size_t i = 0; i < drive.truth.size(); ++i) {
    if (i > 0)
      pose = pose * (drive.truth[i - 1].inverse() * drive.truth[i]) *
             SE2d(0.0, 0.0, Angle::degrees(0.006));
    const LogTime time = LogTime() + from_seconds(static_cast<double>(i));
    drive.drifted.push_back({time, MapPose(pose)});
    const LaserScan scan = sim::simulate_scan(
        plan, [&](LogTime) { return drive.truth[i]; }, time, lidar, rng);
    MappedScan mapped{i, kLidar, thin(end_points(scan, SE2d()), 0.1F, 20.0F), scan};
    smoother.add(std::move(mapped), pose);
    if (const auto path = smoother.smooth(drive.drifted)) {
      drive.smoothed = *path;
      drive.drifted = *path;
      pose = path->back().T_map_base.raw();
    }
  }
  for (SE2d& t : drive.truth) t = origin.inverse() * t;
  return drive;
}

double largest_m(const Trajectory& path, const std::vector<SE2d>& truth) {
  double largest = 0.0;
  for (std::size_t i = 1; i < path.size(); ++i)
    largest = std::max(
        largest, (path[i].T_map_base.raw().translation() - truth[i - 1].translation()).norm());
  return largest;
}

// 0.006° in 10 cm are 2° over the loop.
TEST(LoopSmoother, DistributesTheErrorOverTheLoop) {
  RadarSlamOptions none;
  none.loops.gap_m = 0.0;
  const SmoothedDrive drifted = smoothed_drive(5.0, none), drive = smoothed_drive(5.0, {});
  ASSERT_FALSE(drive.smoothed.empty());
  EXPECT_LT(largest_m(drive.smoothed, drive.truth),
            0.7 * largest_m(drifted.drifted, drifted.truth));
}

TEST(LoopSmoother, WithoutAnEarlierVisitThePathStays) {
  RadarSlamOptions options;
  options.loops.gap_m = 100.0;
  EXPECT_TRUE(smoothed_drive(5.0, options).smoothed.empty());
  options.loops.gap_m = 0.0;
  EXPECT_TRUE(smoothed_drive(5.0, options).smoothed.empty());
}

TEST(LoopSmoother, TheMapsAreThoseOfAllScans) {
  RadarSlamOptions options;
  LoopSmoother smoother(options);
  Trajectory path{{LogTime(), MapPose(SE2d())}};
  PointSet one;
  one.push_back({1.0F, 0.0F});
  for (std::size_t i = 0; i < 2; ++i) {
    const SE2d pose(static_cast<double>(i), 0.0, Angle());
    path.push_back({LogTime() + from_seconds(static_cast<double>(i)), MapPose(pose)});
    smoother.add({i, kRadar, one}, pose);
  }
  const RbpfMaps maps =
      smoother.maps(path, {OccupancyGrid(options.lidar.grid), OccupancyGrid(options.radar.grid)});
  for (const double x : {1.0, 2.0})
    EXPECT_GT(
        maps.radar.log_odds(cell_of(Eigen::Vector2d(x, 0.0), maps.radar.resolution_m())).fixed, 0);
}

}  // namespace
}  // namespace wayfare
