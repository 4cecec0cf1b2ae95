// Simulates a robot's run through a floor plan and writes it as a log.

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include <wayfare/io/carmen.hpp>
#include <wayfare/io/map_image.hpp>
#include <wayfare/io/text_file.hpp>
#include <wayfare/io/tum.hpp>
#include <wayfare/io/voxel_text.hpp>
#include <wayfare/sim/floor_plan.hpp>
#include <wayfare/sim/simulate_recording.hpp>
#include <wayfare/sim/worlds.hpp>

#include "support/command_line.hpp"
#include "support/exit_code.hpp"
#include "support/progress_line.hpp"

namespace {

using namespace wayfare;

struct Options {
  std::string plan;
  std::vector<std::pair<double, double>> waypoints;
  std::string log;
  std::string truth;
  std::string voxels, way;
  std::uint64_t seed = 1;
  bool print_plan = false;
  bool use_gyro = false;
  bool full_circle = false;
  std::size_t beams = 180;
  double scan_rate_hz = 5.0;
  bool force = false;
  bool quiet = false;
  sim::RobotParams robot;
};

void add_options(examples::CommandLine& app, Options& o) {
  app.add_option(
      "PLAN", o.plan,
      "a world's name, a floor plan as text, or the .yaml file of a map picture; without "
      "it, the built-in building");
  app.add_option("--waypoint", o.waypoints,
                 "X Y in metres, once for every place to drive through; replaces the plan's route "
                 "(not a world's)")
      .take_all();
  examples::Option voxels =
      app.add_option("--voxels", o.voxels,
                     "a real building as a world: the voxels of its map, one 'x y z' a line");
  app.add_option("--way", o.way, "places its carrier went through, one 'x,y,z' a line")
      .needs("--voxels");
  voxels.needs("--way");
  app.add_option("--out", o.log, "the CARMEN log to write");
  app.add_option("--truth", o.truth, "where the robot really was, as a TUM trajectory");
  app.add_option("--seed", o.seed, "the same seed gives the same log").show_default();
  app.add_flag("--print-plan", o.print_plan, "print the built-in building's plan and end");
  app.add_flag("--force", o.force, "replace files that are there already");
  app.add_flag("--quiet", o.quiet, "no progress, no summary");
}

void add_robot_options(examples::CommandLine& app, Options& o) {
  const auto number = [&](const char* name, double& value, double low, double high,
                          const char* text) {
    app.add_option(name, value, text).range(low, high).show_default();
  };
  number("--speed", o.robot.drive.max_speed_m_s, 0.01, 20.0, "largest speed, m/s");
  app.add_option("--beams", o.beams, "beams of a scan").range(1, 100000).show_default();
  app.add_flag("--full-circle", o.full_circle, "beams all around (else 180 deg ahead)");
  number("--scan-rate", o.scan_rate_hz, 0.01, 1000.0, "scans a second");
  number("--max-range", o.robot.lidar.max_range_m, 0.5, 1000.0, "m");
  number("--range-noise", o.robot.lidar.range_noise_m, 0.0, 10.0, "standard deviation, m");
  number("--missed", o.robot.lidar.missed_return, 0.0, 1.0, "probability that a beam is lost");
  number("--slip", o.robot.wheels.slip_m_per_sqrt_m, 0.0, 10.0,
         "standard deviation of a wheel's slip after one metre, m");
  number("--left-scale", o.robot.wheels.left_scale, 0.1, 10.0, "metres reported per metre rolled");
  number("--right-scale", o.robot.wheels.right_scale, 0.1, 10.0, "the same of the right wheel");
  app.add_flag("--gyro", o.use_gyro, "odometry turns by the gyro, not by the wheels");
  number("--gyro-bias", o.robot.gyro.bias_rad_s, -1.0, 1.0, "rad/s");
  number("--gyro-walk", o.robot.gyro.angle_random_walk_rad_per_sqrt_s, 0.0, 10.0,
         "standard deviation of the angle after one second, rad");
}

void complete(Options& o) {
  if (o.full_circle) {
    const sim::Lidar2dParams around = sim::full_circle(o.beams);
    o.robot.lidar.first_bearing = around.first_bearing;
    o.robot.lidar.bearing_step = around.bearing_step;
  } else {
    o.robot.lidar.bearing_step = Angle::degrees(180.0 / static_cast<double>(o.beams));
  }
  o.robot.lidar.beams = o.beams;
  o.robot.scan_period = from_seconds(1.0 / o.scan_rate_hz);
  o.robot.heading = o.use_gyro ? sim::HeadingSource::gyro : sim::HeadingSource::wheels;
}

// Whatever a map does not know to be free is wall, so that the rooms are closed.
Result<sim::PlannedRoute> plan_of_map(const std::string& yaml_path) {
  const auto map = io::read_map(yaml_path);
  if (!map) return map.error();
  sim::CellMask mask{
      static_cast<int>(map->width), static_cast<int>(map->height), map->resolution_m, {}};
  for (std::size_t row = map->height; row-- > 0;) {
    for (std::size_t column = 0; column < map->width; ++column) {
      const float occupancy = map->occupancy[row * map->width + column];
      mask.solid.push_back(occupancy < 0.5F ? 0 : 1);  // NaN is unknown: 1
    }
  }
  auto plan = sim::FloorPlan::from_cells(mask);
  if (!plan) return Error{plan.error().code, plan.error().message, yaml_path};
  return sim::PlannedRoute{std::move(plan).value(), {}};
}

Result<sim::PlannedRoute> read_any_plan(const std::string& path) {
  if (path.empty()) return sim::read_plan(sim::demo_building(), "the built-in building");
  if (path.ends_with(".yaml")) return plan_of_map(path);
  const auto text = io::read_file(path);
  if (!text) return text.error();
  return sim::read_plan(text->bytes, path);
}

Result<sim::PlannedRoute> load_plan(const Options& o) {
  auto planned = read_any_plan(o.plan);
  if (!planned) return planned;
  if (!o.waypoints.empty()) planned->route_m.clear();
  for (const auto& [x, y] : o.waypoints) planned->route_m.emplace_back(x, y);
  if (planned->route_m.size() >= 2) return planned;
  return Error{ErrorCode::invalid,
               "a route is needed: a 'route' line with two places or more, or --waypoint X Y twice",
               o.plan};
}

Result<void> refuse_existing(const Options& o) {
  for (const std::string& path : {o.log, o.truth}) {
    std::error_code code;
    if (o.force || path.empty() || !std::filesystem::exists(path, code)) continue;
    return Error{ErrorCode::io, "is there already; --force overwrites it", path};
  }
  return {};
}

bool is_world(const std::string& name) {
  const auto names = sim::world_names();
  return std::any_of(names.begin(), names.end(), [&](const auto& w) { return w.name == name; });
}

std::string footer() {
  std::string text = "Worlds, driven by a Turtlebot with wheels, gyro, LiDAR and radar:\n";
  for (const sim::WorldName& world : sim::world_names()) {
    (text += "  ") += world.name;
    text.append(18 - world.name.size(), ' ') += world.description;
    text += '\n';
  }
  return text + "The robot's options are for plans; a world's robot is as it is.";
}

Result<sim::World> world_of(const Options& o, const Rng& rng) {
  if (o.voxels.empty()) return sim::make_world(o.plan, rng);
  const auto voxels = io::read_points(o.voxels), way = io::read_points(o.way);
  if (!voxels) return voxels.error();
  if (!way) return way.error();
  return sim::world_of_voxels(voxels->points_m, way->points_m, {}, rng);
}

Result<Recording> run_world(const Options& o) {
  const Rng rng(o.seed);
  const auto world = world_of(o, rng);
  if (!world) return world.error();
  examples::ProgressLine progress("simulating", o.quiet);
  auto recording = sim::simulate_world(*world, sim::turtlebot(rng), rng,
                                       {[&](double fraction) { progress.update(fraction); }, {}});
  if (recording) progress.finish();
  return recording;
}

void print_world(const Options& o, const Recording& r) {
  std::size_t points = 0;
  for (const RadarScan& scan : r.radar) points += scan.points.size();
  std::printf("%s: %zu scans, %zu radar frames with %zu points, %zu wheel samples, %.1f s\n",
              o.log.c_str(), r.scans.size(), r.radar.size(), points, r.wheels.size(),
              to_seconds(r.truth.back().time - r.truth.front().time));
}

Result<void> simulate_in_world(const Options& o) {
  const auto recording = run_world(o);
  if (!recording) return recording.error();
  const io::WriteOptions write{o.force ? io::Existing::replace : io::Existing::refuse};
  if (auto done = io::write_carmen(o.log, *recording, write); !done) return done;
  if (!o.truth.empty()) {
    if (auto done = io::write_tum(o.truth, recording->truth, write); !done) return done;
  }
  if (!o.quiet) print_world(o, *recording);
  return {};
}

Result<void> run(const Options& o) {
  if (auto clear = refuse_existing(o); !clear) return clear;
  if (!o.voxels.empty() || is_world(o.plan)) return simulate_in_world(o);
  const auto planned = load_plan(o);
  if (!planned) return planned.error();
  examples::ProgressLine progress("simulating", o.quiet);
  const auto simulated =
      sim::simulate_recording(planned->plan, planned->route_m, o.robot, Rng(o.seed),
                              {[&](double fraction) { progress.update(fraction); }, {}});
  if (!simulated) return simulated.error();
  progress.finish();

  const io::WriteOptions write{o.force ? io::Existing::replace : io::Existing::refuse};
  if (auto done = io::write_carmen(o.log, simulated->recording, write); !done) return done;
  if (!o.truth.empty()) {
    if (auto done = io::write_tum(o.truth, simulated->truth, write); !done) return done;
  }
  if (o.quiet) return {};
  const Duration length = simulated->truth.back().time - simulated->truth.front().time;
  std::printf("%s: %zu scans, %zu odometry samples, %.1f s\n", o.log.c_str(),
              simulated->recording.scans.size(), simulated->recording.odometry.size(),
              to_seconds(length));
  return {};
}

}  // namespace

int main(int argc, char** argv) {
  examples::CommandLine app("Simulate a robot with wheels, gyro and a 2D LiDAR in a floor plan.");
  app.footer(footer());
  Options options;
  add_options(app, options);
  add_robot_options(app, options);
  if (const auto code = app.parse(argc, argv)) return *code;
  if (options.print_plan) {
    std::fputs(std::string(sim::demo_building()).c_str(), stdout);
    return 0;
  }
  if (options.log.empty()) {
    std::fputs("simulate: --out LOG is needed (see --help)\n", stderr);
    return 2;
  }
  complete(options);
  return examples::exit_code("simulate", run(options));
}
