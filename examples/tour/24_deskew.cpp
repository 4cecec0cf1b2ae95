// A LiDAR that turns at 5.5 Hz on a robot that turns itself: what it makes of a square room, and
// the room again once each point is moved to where the laser was in the middle of the sweep.
#include <algorithm>
#include <cmath>
#include <cstdio>

#include <wayfare/sensors/deskew.hpp>
#include <wayfare/sensors/point_set.hpp>
#include <wayfare/sensors/pose_history.hpp>
#include <wayfare/sim/floor_plan.hpp>

using namespace wayfare;

// The farthest point from the walls of the room, 8 m x 8 m about the origin.
double off_the_walls(const PointSet& points) {
  double worst = 0.0;
  for (std::size_t i = 0; i < points.size(); ++i)
    worst = std::max(worst, std::abs(points[i].cwiseAbs().maxCoeff() - 4.0));
  return worst;
}

int main() {
  const auto room = sim::FloorPlan::from_segments(
      {{{-4, -4}, {4, -4}}, {{4, -4}, {4, 4}}, {{4, 4}, {-4, 4}}, {{-4, 4}, {-4, -4}}});
  // 1 m/s and 90 degrees per second.
  const auto robot = [](LogTime time) {
    return SE2d().plus(time.seconds() * Eigen::Vector3d(1.0, 0.0, (90_deg).radians()));
  };
  sim::Lidar2dParams lidar = sim::full_circle(360);
  lidar.range_noise_m = lidar.missed_return = 0.0;
  lidar.sweep = from_seconds(0.1813);
  Rng rng(1);
  const LogTime start = LogTime::from_seconds(1.0);
  const LaserScan sweep = sim::simulate_scan(*room, robot, start, lidar, rng);
  const SE2d T_room_laser = robot(sweep.time);
  std::printf("as it is: %.2f m off the walls\n", off_the_walls(end_points(sweep, T_room_laser)));

  // Poses as odometry gives them, at 50 Hz; any callable from a time to a pose will do.
  PoseHistory<SE2d> odometry;
  for (int i = 0; i < 80; ++i) {
    const LogTime time = LogTime::from_seconds(0.02 * i);
    if (!odometry.add(time, robot(time))) return 1;
  }
  LaserScan instant;
  if (!deskew(sweep, odometry, sweep.time, instant)) return 1;
  std::printf("undone: %.3f m\n", off_the_walls(end_points(instant, T_room_laser)));

  // A motion that ends in the middle of the sweep.
  PoseHistory<SE2d> first_half;
  (void)first_half.add(start, robot(start));
  (void)first_half.add(sweep.time, robot(sweep.time));
  const auto done = deskew(sweep, first_half, sweep.time, instant);
  std::printf("%s\n", done ? "covered" : done.error().message.c_str());
}
