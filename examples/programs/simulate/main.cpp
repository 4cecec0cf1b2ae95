// Simulates a robot's run through a floor plan and writes its log.

#include <algorithm>
#include <cstdio>
#include <string>
#include <utility>
#include <vector>

#include <wayfare/io/carmen.hpp>
#include <wayfare/io/map_image.hpp>
#include <wayfare/io/tum.hpp>
#include <wayfare/sim/floor_plan.hpp>
#include <wayfare/sim/simulate_recording.hpp>
#include <wayfare/sim/worlds.hpp>

#include "support/chirp_config.hpp"
#include "support/plans.hpp"
#include "support/program_files.hpp"
#include "support/progress_line.hpp"

namespace {

using namespace wayfare;
using namespace wayfare::examples;

struct Options : OutputArguments {
  std::string plan, truth, voxels, route, chirps;
  std::vector<std::pair<double, double>> waypoints;
  std::uint64_t seed = 1;
  bool print_plan = false;
  bool use_gyro = false;
  bool full_circle = false;
  std::size_t beams = 180;
  double scan_rate_hz = 5.0, sweep_ms = 0.0;
  sim::RobotParams robot;
  std::vector<Option> of_plans;  ///< that apply to floor plans, not to worlds
};

void add_options(CommandLine& app, Options& o) {
  app.add_option(
      "PLAN", o.plan,
      "a world's name, a floor plan as text, or the .yaml file of a map picture; without "
      "it, the built-in building");
  o.of_plans.push_back(
      app.add_option("--waypoint", o.waypoints,
                     "X Y in metres, once per waypoint; replaces the plan's route (not a world's)")
          .take_all());
  Option voxels =
      app.add_option("--voxels", o.voxels,
                     "a real building as a world: the voxels of its map, 'x y z' on each line");
  app.add_option("--way", o.route, "path through it, 'x,y,z' on each line").needs("--voxels");
  voxels.needs("--way");
  app.add_number("--sweep", o.sweep_ms, 0.0, 10000.0,
                 "time from a scan's first beam to its last, ms; 0: all beams at one instant");
  add_chirps(app, o.chirps);
  app.add_option("--out", o.out, "the CARMEN log to write").shown_as("FILE");
  app.add_option("--truth", o.truth, "file for the true poses, as a TUM trajectory")
      .shown_as("FILE");
  app.add_option("--seed", o.seed, kSeedHelp).show_default();
  app.add_flag("--print-plan", o.print_plan, "print the plan of the built-in building and exit");
  add_force_and_quiet(app, o);
}

void add_robot_options(CommandLine& app, Options& o) {
  for (const Option& option :
       {app.add_number("--speed", o.robot.drive.max_speed_m_s, 0.01, 20.0, "largest speed, m/s"),
        app.add_number("--beams", o.beams, 1, 100000, "beams per scan"),
        app.add_flag("--full-circle", o.full_circle, "beams all around (else 180 deg ahead)"),
        app.add_number("--scan-rate", o.scan_rate_hz, 0.01, 1000.0, "scans per second"),
        app.add_number("--max-range", o.robot.lidar.max_range_m, 0.5, 1000.0, "largest range, m"),
        app.add_number("--range-noise", o.robot.lidar.range_noise_m, 0.0, 10.0,
                       "standard deviation of a range, m"),
        app.add_number("--missed", o.robot.lidar.missed_return, 0.0, 1.0,
                       "probability that a beam is lost"),
        app.add_number("--slip", o.robot.wheels.slip_m_per_sqrt_m, 0.0, 10.0,
                       "standard deviation of a wheel's slip after one metre, m"),
        app.add_number("--left-scale", o.robot.wheels.left_scale, 0.1, 10.0,
                       "metres reported per metre rolled"),
        app.add_number("--right-scale", o.robot.wheels.right_scale, 0.1, 10.0,
                       "the same for the right wheel"),
        app.add_flag("--gyro", o.use_gyro,
                     "heading of the odometry from the gyro, not from the wheels"),
        app.add_number("--gyro-bias", o.robot.gyro.bias_rad_s, -1.0, 1.0,
                       "bias of the gyro, rad/s"),
        app.add_number("--gyro-walk", o.robot.gyro.angle_random_walk_rad_per_sqrt_s, 0.0, 10.0,
                       "standard deviation of the angle after one second, rad")})
    o.of_plans.push_back(option);
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
  o.robot.lidar.sweep = from_seconds(1e-3 * o.sweep_ms);
  o.robot.scan_period = from_seconds(1.0 / o.scan_rate_hz);
  o.robot.heading = o.use_gyro ? sim::HeadingSource::gyro : sim::HeadingSource::wheels;
}

Result<sim::PlannedRoute> load_plan(const Options& o) {
  auto planned = read_any_plan(o.plan);
  if (!planned) return planned;
  if (!o.waypoints.empty()) planned->route_m.clear();
  for (const auto& [x, y] : o.waypoints) planned->route_m.emplace_back(x, y);
  if (planned->route_m.size() >= 2) return planned;
  return Error{
      ErrorCode::invalid,
      "a route is needed: a 'route' line with at least two points, or --waypoint X Y twice",
      o.plan};
}

std::string footer() {
  std::string text = "Worlds, driven by a Turtlebot with wheels, gyro, LiDAR and radar:\n";
  for (const sim::WorldName& world : sim::world_names()) {
    (text += "  ") += world.name;
    text.append(18 - world.name.size(), ' ') += world.description;
    text += '\n';
  }
  return text + "The robot's options are for plans; the robot and the route of a world are fixed.";
}

Result<sim::World> world_of(const Options& o, const Rng& rng) {
  if (o.voxels.empty()) return sim::make_world(o.plan, rng);
  const auto voxels = io::read_points(o.voxels), route = io::read_points(o.route);
  if (!voxels) return voxels.error();
  if (!route) return route.error();
  return sim::world_of_voxels(voxels->points_m, route->points_m, {}, rng);
}

/// The simulated radar with the configuration's grid, limits, field of view and frame rate.
Result<void> configure(const std::string& path, sim::RadarMount& mount) {
  constexpr int kAntennas = 8;
  const auto chirps = read_chirps(path);
  if (!chirps) return chirps.error();
  const decode::TiLimits& l = chirps->limits;
  const decode::TiConfig& c = chirps->config;
  sim::RadarParams& radar = mount.radar;
  const auto unsupported = [&](const char* what) {
    return Error{ErrorCode::unsupported, what, path};
  };
  if (l.azimuth_antennas != kAntennas)
    return unsupported("only radars with eight antennas in a row are simulated");
  if (static_cast<std::size_t>(l.doppler_bins) <= 2 * (radar.doppler_guard + radar.doppler_window))
    return unsupported("too few Doppler bins for the simulated detector");
  radar.range_bin_m = l.range_step_m;
  radar.doppler_bin_m_s = l.speed_step_mps;
  radar.doppler_bins = static_cast<std::size_t>(l.doppler_bins);
  radar.wavelength_m = 3e8 / l.centre_hz;
  // What the chirps reach is far beyond what a detector of so few points reports.
  radar.max_range_m = std::min(l.max_range_m, 2.0 * radar.max_range_m);
  radar.min_range_m = std::max(radar.min_range_m, c.min_range_m);
  radar.min_azimuth = c.min_azimuth, radar.max_azimuth = c.max_azimuth;
  mount.period = from_seconds(1e-3 * c.frame.period_ms);
  return {};
}

Result<Recording> simulate_in_world(const Options& o) {
  for (const Option& option : o.of_plans)
    if (option.given())
      return bad_use(o.plan + ": " + option.name() +
                     " is for floor plans: the robot and the route of a world are fixed");
  const Rng rng(o.seed);
  const auto world = world_of(o, rng);
  if (!world) return world.error();
  ProgressLine progress("simulating", o.quiet);
  sim::WorldRobot robot = sim::turtlebot(rng);
  robot.robot.lidar.sweep = o.robot.lidar.sweep;
  if (!o.chirps.empty())
    if (auto ok = configure(o.chirps, robot.radar); !ok) return ok.error();
  auto recording = sim::simulate_world(*world, robot, rng, {std::ref(progress), {}});
  if (recording) progress.finish();
  return recording;
}

Result<sim::SimulatedRun> simulate_in_plan(const Options& o) {
  const auto planned = load_plan(o);
  if (!planned) return planned.error();
  ProgressLine progress("simulating", o.quiet);
  auto simulated = sim::simulate_recording(planned->plan, planned->route_m, o.robot, Rng(o.seed),
                                           {std::ref(progress), {}});
  if (simulated) progress.finish();
  return simulated;
}

Result<void> write(const Options& o, const Recording& r, const Trajectory& truth,
                   const std::string& contents) {
  if (auto done = io::write_carmen(o.out, r, o.write()); !done) return done;
  if (!o.truth.empty())
    if (auto done = io::write_tum(o.truth, truth, o.write()); !done) return done;
  if (!o.quiet)
    std::printf("%s: %zu scans, %s, %.1f s\n", o.out.c_str(), r.scans.size(), contents.c_str(),
                to_seconds(truth.back().time - truth.front().time));
  return {};
}

Result<void> run(const Options& o) {
  if (auto ok = check_writable({o.out, o.truth}, o.write()); !ok) return ok;
  if (o.voxels.empty() && !is_world(o.plan)) {
    const auto run = simulate_in_plan(o);
    if (!run) return run.error();
    return write(o, run->recording, run->truth,
                 std::to_string(run->recording.odometry.size()) + " odometry samples");
  }
  const auto recording = simulate_in_world(o);
  if (!recording) return recording.error();
  std::size_t points = 0;
  for (const RadarScan& scan : recording->radar) points += scan.points.size();
  return write(o, *recording, recording->truth,
               std::to_string(recording->radar.size()) + " radar frames with " +
                   std::to_string(points) + " points, " + std::to_string(recording->wheels.size()) +
                   " wheel samples");
}

}  // namespace

int main(int argc, char** argv) {
  CommandLine app("Simulate a robot with wheels, gyro and a 2D LiDAR in a floor plan.");
  app.footer(footer());
  Options options;
  add_options(app, options);
  add_robot_options(app, options);
  app.example("--out robot.log --truth truth.tum", "the built-in building");
  app.example("corridor_loop --out robot.log", "a world with radar");
  app.example("floor.plan --waypoint 1 1 --waypoint 5 1 --out robot.log",
              "an own floor plan and route");
  if (const auto code = app.parse(argc, argv)) return *code;
  if (options.print_plan) {
    std::fputs(std::string(sim::demo_building()).c_str(), stdout);
    return 0;
  }
  if (options.out.empty()) return exit_code("simulate", bad_use("--out LOG is needed"));
  complete(options);
  return exit_code("simulate", run(options));
}
