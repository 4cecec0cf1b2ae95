#include <wayfare/sim/worlds.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>

#include "sim/world/places.hpp"

namespace wayfare::sim {
namespace {

using Eigen::Vector2d;

enum WorldStream : std::uint64_t { kFurniture, kRobot, kDrive, kRadar, kPeople };

constexpr std::array<WorldName, 6> kWorlds{{
    {"corridor_loop", "long corridors around a block, 18 m x 30 m, one lap and a bit"},
    {"corridor_tee",
     "two corridors that meet in a T, 24 m and 14 m, each driven to its end and back"},
    {"pillar_hall", "a hall of 14 m x 18 m with pillars and four people walking, two laps"},
    {"room", "a room of 6 m x 8 m with a little furniture, two laps"},
    {"cluttered_room", "the same room full of objects, driven to and fro over the same floor"},
    {"calibration_room", "the room without clutter, both ways round, with turns on the spot"},
}};

// The walls of a closed polygon, and the posts of recessed doors in them.
class Walls {
 public:
  void add_polygon(const std::vector<Vector2d>& corners) {
    for (std::size_t i = 0; i < corners.size(); ++i)
      segments_.push_back({corners[i], corners[(i + 1) % corners.size()]});
  }
  void add_box(const Vector2d& lower, const Vector2d& upper) {
    add_polygon({lower, {upper.x(), lower.y()}, upper, {lower.x(), upper.y()}});
  }
  // A wall from `a` to `b` with doors of 0.9 m, recessed to the right.
  void add_wall_with_doors(const Vector2d& a, const Vector2d& b, double recess_m, Rng& rng) {
    constexpr double kDoor_m = 0.9;
    const double length = (b - a).norm();
    const Vector2d along = (b - a) / length, back = recess_m * Vector2d(along.y(), -along.x());
    double at = 0.0;
    while (true) {
      const double door = at + rng.uniform(1.2, 5.0);
      if (door + kDoor_m + 1.0 > length) break;
      const Vector2d left = a + door * along, right = a + (door + kDoor_m) * along;
      segments_.push_back({a + at * along, left});
      segments_.push_back({left, left + back});
      segments_.push_back({left + back, right + back});
      segments_.push_back({right + back, right});
      frames_.push_back(left);
      frames_.push_back(right);
      at = door + kDoor_m;
    }
    segments_.push_back({a + at * along, b});
  }

  std::vector<Segment> segments_;
  std::vector<Vector2d> frames_;
};

// Boxes are always valid walls.
FloorPlan plan_of(std::vector<Segment> segments) {
  return std::move(FloorPlan::from_segments(std::move(segments))).value();
}

World corridor_loop(const Rng& rng) {
  constexpr double kWidth_m = 18.0, kLength_m = 30.0, kCorridor_m = 2.2, kRecess_m = 0.03;
  Walls walls;
  Rng doors = rng.stream(kDrive);
  const auto ring = [&](double inset, bool outwards) {
    std::vector<Vector2d> c{{inset, inset},
                            {kWidth_m - inset, inset},
                            {kWidth_m - inset, kLength_m - inset},
                            {inset, kLength_m - inset}};
    if (!outwards) std::swap(c[1], c[3]);
    for (std::size_t i = 0; i < 4; ++i)
      walls.add_wall_with_doors(c[i], c[(i + 1) % 4], kRecess_m, doors);
  };
  ring(0.0, true);
  ring(kCorridor_m, false);
  const double m = 0.5 * kCorridor_m, x = kWidth_m - m, y = kLength_m - m;
  // Clockwise, past the start into the second lap.
  std::vector<Vector2d> route{{m, 6.0}, {m, y}, {x, y}, {x, m}, {m, m}, {m, 6.0}, {m, 12.0}};
  World world = furnished_world(plan_of(walls.segments_), std::move(route), walls.frames_, {}, rng);
  world.carpets.push_back({{8.0, 0.0}, {12.0, kCorridor_m}});
  return world;
}

// The stem leads up to the middle of the bar.
World corridor_tee(const Rng& rng) {
  constexpr double kBar_m = 24.0, kStem_m = 14.0, kWidth_m = 2.2, kRecess_m = 0.03;
  constexpr double kLeft_m = 0.5 * (kBar_m - kWidth_m), kRight_m = kLeft_m + kWidth_m;
  constexpr double kTop_m = kStem_m + kWidth_m;
  Walls walls;
  Rng doors = rng.stream(kDrive);
  const std::vector<Vector2d> c{{kLeft_m, 0.0},    {kRight_m, 0.0},   {kRight_m, kStem_m},
                                {kBar_m, kStem_m}, {kBar_m, kTop_m},  {0.0, kTop_m},
                                {0.0, kStem_m},    {kLeft_m, kStem_m}};
  for (std::size_t i = 0; i < c.size(); ++i)
    walls.add_wall_with_doors(c[i], c[(i + 1) % c.size()], kRecess_m, doors);
  const double x = 0.5 * kBar_m, y = kStem_m + 0.5 * kWidth_m;
  std::vector<Vector2d> route{{x, 1.2}, {x, y}, {kBar_m - 1.2, y}, {x, y},
                              {1.2, y}, {x, y}, {x, 1.2},          {x, 6.0}};
  return furnished_world(plan_of(walls.segments_), std::move(route), walls.frames_, {}, rng);
}

World pillar_hall(const Rng& rng) {
  constexpr double kWidth_m = 14.0, kLength_m = 18.0, kPillar_m = 0.4;
  Walls walls;
  Rng doors = rng.stream(kDrive);
  const std::array<Vector2d, 4> c{
      {{0.0, 0.0}, {kWidth_m, 0.0}, {kWidth_m, kLength_m}, {0.0, kLength_m}}};
  for (std::size_t i = 0; i < 4; ++i) walls.add_wall_with_doors(c[i], c[(i + 1) % 4], 0.05, doors);
  for (const double x : {3.5, 7.0, 10.5})
    for (const double y : {3.6, 7.2, 10.8, 14.4}) {
      const Vector2d shift(doors.uniform(-0.2, 0.2), doors.uniform(-0.2, 0.2));
      const Vector2d half(0.5 * kPillar_m, 0.5 * kPillar_m), at = Vector2d(x, y) + shift;
      walls.add_box(at - half, at + half);
    }
  const std::vector<Vector2d> lap{{1.8, 1.8}, {12.2, 1.8}, {12.2, 16.2}, {1.8, 16.2}};
  std::vector<Vector2d> route(lap);
  route.insert(route.end(), lap.begin(), lap.end());
  route.push_back(lap[0]);
  World world = furnished_world(plan_of(walls.segments_), std::move(route), walls.frames_, {}, rng);
  world.walkers = walkers_along(lap, 4, rng.stream(kPeople));
  return world;
}

World room(const Rng& rng, bool cluttered) {
  Walls walls;
  Rng doors = rng.stream(kDrive);
  const std::array<Vector2d, 4> c{{{0.0, 0.0}, {6.0, 0.0}, {6.0, 8.0}, {0.0, 8.0}}};
  for (std::size_t i = 0; i < 4; ++i) walls.add_wall_with_doors(c[i], c[(i + 1) % 4], 0.05, doors);
  walls.add_box({5.2, 3.0}, {5.9, 4.6});  // cupboard
  walls.add_box({0.1, 6.9}, {1.3, 7.6});  // desk
  walls.add_box({2.7, 3.6}, {3.2, 4.4});  // table
  std::vector<Vector2d> route{{1.2, 1.2}, {4.4, 1.2}, {4.4, 6.6}, {2.0, 6.2}, {1.2, 1.2},
                              {4.4, 1.2}, {4.4, 6.6}, {2.0, 6.2}, {1.2, 2.0}};
  if (cluttered) {
    walls.add_box({1.9, 1.9}, {2.3, 2.3});
    walls.add_box({1.8, 5.2}, {2.5, 5.5});
    walls.add_box({3.6, 5.4}, {3.9, 6.3});
    walls.add_box({4.3, 0.2}, {5.2, 0.6});
    walls.add_box({0.1, 3.0}, {0.5, 4.2});
    walls.add_box({3.7, 2.1}, {4.0, 2.6});
    route = {{1.2, 1.2}, {3.2, 1.3}, {4.7, 1.9}, {4.6, 4.8}, {4.7, 7.0}, {2.8, 7.0},
             {1.2, 6.2}, {1.2, 4.4}, {1.2, 1.2}, {1.2, 4.4}, {1.2, 6.2}, {2.8, 7.0},
             {4.7, 7.0}, {4.6, 4.8}, {4.7, 1.9}, {3.2, 1.3}, {1.2, 1.2}, {1.2, 3.0}};
  }
  FurnishParams params;
  if (cluttered) params.floor_per_m2 *= 2.0;
  World world =
      furnished_world(plan_of(walls.segments_), std::move(route), walls.frames_, params, rng);
  world.carpets.push_back({{3.2, 0.2}, {5.0, 2.4}});
  return world;
}

// Velocity of the radar in its own axes, from the poses around the frame.
Vector2d velocity_at(const Trajectory& truth, LogTime time, const SE2d& T_base_radar) {
  constexpr Duration kHalf{10'000'000};
  const SE2d before = true_pose_at(truth, time - kHalf) * T_base_radar;
  const SE2d after = true_pose_at(truth, time + kHalf) * T_base_radar;
  return after.minus(before).head<2>() / to_seconds(2 * kHalf);
}

Result<std::vector<RadarScan>> record_radar(const World& world, const Trajectory& truth,
                                            const RadarMount& mount, const Rng& rng,
                                            const SimulationControl& control) {
  std::vector<RadarScan> scans;
  const SE2d T_base_radar = mount.T_base_radar.raw();
  const LogTime start = truth.front().time;
  const double length_s = std::max(1e-9, to_seconds(truth.back().time - start));
  WAYFARE_EXPECTS(mount.period > Duration::zero(), "a radar needs a positive period");
  for (LogTime t = start; t <= truth.back().time; t += mount.period) {
    if (control.stop.stop_requested()) return Error{ErrorCode::cancelled, "stopped on request"};
    Rng noise = rng.stream(scans.size());
    std::vector<Reflector> reflectors = reflectors_of(world.walkers, t);
    reflectors.insert(reflectors.begin(), world.reflectors.begin(), world.reflectors.end());
    scans.push_back(simulate_radar(world.plan, reflectors, true_pose_at(truth, t) * T_base_radar,
                                   velocity_at(truth, t, T_base_radar), t, mount.radar, noise));
    if (control.progress) control.progress(to_seconds(t - start) / length_s);
  }
  return scans;
}

}  // namespace
std::span<const WorldName> world_names() { return kWorlds; }

Result<World> make_world(std::string_view name, const Rng& rng) {
  if (name == "corridor_loop") return corridor_loop(rng);
  if (name == "corridor_tee") return corridor_tee(rng);
  if (name == "pillar_hall") return pillar_hall(rng);
  if (name == "room") return room(rng, false);
  if (name == "cluttered_room") return room(rng, true);
  if (name == "calibration_room") {
    World world = room(rng, false);
    world.carpets.clear();
    // Where the route reverses, the robot turns on the spot.
    world.route_m = {{1.2, 1.2}, {4.4, 1.2}, {4.4, 6.4}, {2.0, 6.2}, {1.2, 1.2}, {1.8, 6.0},
                     {4.4, 6.4}, {4.4, 1.4}, {2.2, 1.4}, {1.6, 3.0}, {3.4, 2.4}, {1.4, 2.2}};
    return world;
  }
  std::string message = "there is no world '" + std::string(name) + "'; there are";
  for (const WorldName& world : kWorlds) (message += ' ') += world.name;
  return Error{ErrorCode::not_found, std::move(message)};
}

World furnished_world(FloorPlan plan, std::vector<Vector2d> route_m, std::vector<Vector2d> frames_m,
                      const FurnishParams& params, const Rng& rng) {
  const Interior interior{std::move(frames_m), places_along(route_m)};
  std::vector<Reflector> reflectors = furnish(plan, interior, params, rng.stream(kFurniture));
  return {std::move(plan), std::move(route_m), std::move(reflectors), {}};
}

WorldRobot turtlebot(const Rng& rng) {
  Rng draw = rng.stream(kRobot);
  WorldRobot robot;
  DriveParams& drive = robot.robot.drive;
  drive.max_speed_m_s = 0.25;
  drive.max_turn_rate_rad_s = 0.8;
  drive.max_acceleration_m_s2 = 0.3;
  drive.waypoint_radius_m = 0.15;
  WheelParams& wheels = robot.robot.wheels;
  wheels.wheel_base_m = 0.287;
  wheels.left_scale = draw.normal(1.0, 0.0015);
  wheels.right_scale = draw.normal(1.0, 0.0015);
  wheels.slip_m_per_sqrt_m = 0.006;
  robot.robot.gyro.bias_rad_s = draw.normal(0.0, 0.0015);
  robot.robot.gyro.angle_random_walk_rad_per_sqrt_s = 0.001;
  robot.robot.lidar = full_circle(360);
  robot.robot.lidar.min_range_m = 0.12;
  robot.robot.lidar.max_range_m = 3.5;
  robot.robot.lidar.range_noise_m = 0.015;
  robot.robot.odometry_period = Duration(50'000'000);
  robot.robot.T_base_laser = Transform2<frame::Base, frame::Laser>(SE2d(-0.064, 0.0, Angle{}));
  robot.robot.radius_m = 0.15;
  robot.radar.T_base_radar = Transform2<frame::Base, frame::Radar>(SE2d(0.08, 0.0, Angle{}));
  return robot;
}

Result<Recording> simulate_world(const World& world, const WorldRobot& robot, const Rng& rng,
                                 const SimulationControl& control) {
  SimulationControl part = control;
  constexpr double kLidarShare = 0.2;
  if (control.progress) part.progress = [&](double f) { control.progress(kLidarShare * f); };
  RobotParams params = robot.robot;
  params.wheels.carpets = world.carpets;
  auto run = simulate_recording(world.plan, world.route_m, params, rng.stream(kDrive), part);
  if (!run) return run.error();
  const Rng people = rng.stream(kPeople);
  for (std::size_t i = 0; i < run->recording.scans.size(); ++i) {
    LaserScan& scan = run->recording.scans[i];
    Rng noise = people.stream(i);
    overlay_walkers(scan, world.walkers,
                    true_pose_at(run->truth, scan.time) * params.T_base_laser.raw(), params.lidar,
                    noise);
  }
  if (control.progress)
    part.progress = [&](double f) { control.progress(kLidarShare + (1.0 - kLidarShare) * f); };
  auto radar = record_radar(world, run->truth, robot.radar, rng.stream(kRadar), part);
  if (!radar) return radar.error();
  Recording recording = std::move(run->recording);
  recording.T_base_radar = robot.radar.T_base_radar;
  recording.radar = std::move(radar).value();
  const RadarParams& signal = robot.radar.radar;
  recording.radar_max_speed_m_s =
      0.5 * signal.doppler_bin_m_s * static_cast<double>(signal.doppler_bins);
  recording.wheel_base_m = params.wheels.wheel_base_m;
  recording.wheels = std::move(run->wheels);
  recording.gyro = std::move(run->gyro);
  for (LogTime due; const StampedPose& pose : run->truth) {
    if (pose.time < due) continue;
    recording.truth.push_back(pose);
    due = pose.time + params.odometry_period;
  }
  return recording;
}

}  // namespace wayfare::sim
