// Calibration of a robot from simulated drives with known geometry, over many seeds.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <string>
#include <vector>

#include <wayfare/core/statistics.hpp>
#include <wayfare/sim/robot_geometry.hpp>
#include <wayfare/sim/worlds.hpp>
#include <wayfare/slam/robot_calibration.hpp>

#include "support/plans.hpp"
#include "support/program_files.hpp"
#include "support/progress_line.hpp"
#include "support/slam_program.hpp"

namespace {

using namespace wayfare;
using namespace wayfare::examples;

struct Options {
  std::string world = "calibration_room", without = "nothing";
  int runs = 10;
  std::size_t doppler_bins = 16;
  std::uint64_t first_seed = 1;
  double speed_m_s = 0.25, outliers = 0.0;
  bool quiet = false;
};

/// By the names of RobotCalibration.
std::map<std::string, double> truth_of(const sim::RobotGeometry& g) {
  std::map<std::string, double> t{{"wheels.left_scale", g.left_scale},
                                  {"wheels.right_scale", g.right_scale},
                                  {"wheels.base", g.wheel_base_m},
                                  {"gyro.scale", 1.0},
                                  {"gyro.delay", g.gyro_delay_s}};
  const auto add = [&](const std::string& name, const SE2d& pose, double delay_s) {
    t[name + ".x"] = pose.x(), t[name + ".y"] = pose.y();
    t[name + ".yaw"] = pose.heading().radians(), t[name + ".delay"] = delay_s;
  };
  add("laser", g.T_base_laser, g.laser_delay_s), add("radar", g.T_base_radar, g.radar_delay_s);
  add("laser_to_radar", g.T_base_laser.inverse() * g.T_base_radar,
      g.radar_delay_s - g.laser_delay_s);
  return t;
}

/// Errors of one parameter over the seeds.
struct Errors {
  std::vector<double> error, sigma;
  std::vector<std::uint64_t> seeds;
  std::size_t undetermined = 0;
  std::string unit;
};

void add(std::map<std::string, Errors>& all, std::vector<std::string>& order,
         const RobotCalibration& found, const std::map<std::string, double>& truth,
         std::uint64_t seed) {
  for (const CalibratedParameter& p : found.parameters) {
    if (!truth.contains(p.name)) continue;
    if (!all.contains(p.name)) order.push_back(p.name);
    Errors& e = all[p.name];
    e.unit = p.unit;
    if (!p.determined) {
      ++e.undetermined;
      continue;
    }
    const double off = p.value - truth.at(p.name);
    e.error.push_back(p.unit == "rad" ? std::remainder(off, 2.0 * std::numbers::pi) : off);
    e.sigma.push_back(p.sigma);
    e.seeds.push_back(seed);
  }
}

/// In degrees, millimetres, milliseconds and per cent.
std::pair<double, std::string> shown(const std::string& unit) {
  if (unit == "rad") return {Angle::radians(1.0).degrees(), "deg"};
  if (unit == "m") return {1e3, "mm"};
  if (unit == "s") return {1e3, "ms"};
  return {100.0, "%"};
}

void row(eval::Table& table, const std::string& name, const Errors& e) {
  const auto [factor, unit] = shown(e.unit);
  if (e.error.empty()) {
    table.add_row({name, unit, "–", "–", "–", "–", "–", std::to_string(e.undetermined)});
    return;
  }
  double squares = 0.0, bias = 0.0, nees = 0.0, sigma = 0.0;
  std::size_t worst = 0, beyond = 0;
  const auto n = static_cast<double>(e.error.size());
  for (std::size_t i = 0; i < e.error.size(); ++i) {
    squares += e.error[i] * e.error[i] / n, bias += e.error[i] / n, sigma += e.sigma[i] / n;
    nees += e.error[i] * e.error[i] / (e.sigma[i] * e.sigma[i]) / n;
    if (std::abs(e.error[i]) > std::abs(e.error[worst])) worst = i;
    if (std::abs(e.error[i]) > 2.0 * e.sigma[i]) ++beyond;
  }
  table.add_row({name, unit, eval::fixed(factor * std::sqrt(squares), 2),
                 eval::fixed(factor * bias, 2),
                 eval::fixed(factor * std::abs(e.error[worst]), 2) + " (" +
                     std::to_string(e.seeds[worst]) + ")",
                 eval::fixed(factor * sigma, 2),
                 eval::fixed(nees, 2) + ", " + std::to_string(beyond) + " beyond 2 sigma",
                 std::to_string(e.undetermined)});
}

void disturb(Recording& r, const Options& o, std::uint64_t seed) {
  if (o.without == "laser") r.scans.clear();
  if (o.without == "radar") r.radar.clear();
  if (o.without == "gyro") r.gyro.clear();
  if (o.without == "wheels") r.wheels.clear(), r.odometry.clear();
  Rng rng = Rng(seed).stream(99);
  // Wheels that spin, and frames of something else that moves.
  for (WheelSample& w : r.wheels)
    if (rng.uniform() < o.outliers) w.left_m *= rng.uniform(0.0, 3.0);
  for (RadarScan& scan : r.radar)
    if (rng.uniform() < o.outliers)
      for (RadarPoint& p : scan.points) p.doppler_m_s += 0.4F;
}

Result<void> run(const Options& o) {
  std::map<std::string, Errors> all;
  std::vector<std::string> order;
  for (int i = 0; i < o.runs; ++i) {
    const std::uint64_t seed = o.first_seed + static_cast<std::uint64_t>(i);
    const Rng rng(seed);
    const bool straight = o.world == "straight";
    auto world = sim::make_world(straight ? "calibration_room" : o.world, rng);
    if (!world) return world.error();
    if (straight) world->route_m = {{1.2, 1.2}, {1.2, 6.0}};
    sim::WorldRobot robot = sim::turtlebot(rng);
    robot.robot.drive.max_speed_m_s = o.speed_m_s;
    // The same largest speed.
    sim::RadarParams& radar = robot.radar.radar;
    radar.doppler_bin_m_s *= static_cast<double>(radar.doppler_bins);
    radar.doppler_bins = o.doppler_bins;
    radar.doppler_bin_m_s /= static_cast<double>(radar.doppler_bins);
    RobotCalibrationOptions calibration;
    calibration.velocity.inlier_m_s = 2.5 * radar.doppler_bin_m_s;
    calibration.velocity.doppler_sigma_m_s = radar.doppler_bin_m_s / std::sqrt(12.0);
    const sim::RobotGeometry geometry = sim::draw_geometry(robot, rng);
    ProgressLine simulating("simulating", o.quiet);
    auto recording =
        sim::simulate_misdescribed(*world, robot, geometry, rng, {std::ref(simulating), {}});
    if (!recording) return recording.error();
    disturb(*recording, o, seed);
    ProgressLine timer("calibrating", true);
    const auto found = calibrate_robot(*recording, calibration);
    const double took = timer.finish();
    if (!found) {
      std::printf("seed %d: %s\n", static_cast<int>(seed), found.error().to_string().c_str());
      continue;
    }
    std::string text;
    for (const CalibratedSensor& s : found->sensors)
      text += ", " + s.name + " " + std::to_string(s.measurements) + " (" +
              std::to_string(s.outliers) + " outliers, noise " + eval::fixed(s.noise, 2) + ")";
    std::fprintf(stderr, "seed %d: %.1f s of drive, took %.2f s%s\n", static_cast<int>(seed),
                 to_seconds(recording->truth.back().time - recording->truth.front().time), took,
                 text.c_str());
    add(all, order, *found, truth_of(geometry), seed);
  }
  eval::Table table({{"parameter"},
                     {"unit"},
                     {"RMSE"},
                     {"mean"},
                     {"worst (seed)"},
                     {"sigma"},
                     {"NEES"},
                     {"not determined"}});
  for (const std::string& name : order) row(table, name, all[name]);
  std::printf("%s", table.to_text().c_str());
  return {};
}

}  // namespace

int main(int argc, char** argv) {
  CommandLine app("Calibrate simulated robots of known geometry and print the errors over seeds.");
  Options o;
  std::vector<std::string> worlds = world_names();
  worlds.emplace_back("straight");
  app.add_option("--world", o.world, "a world of simulate, or straight")
      .one_of(worlds)
      .show_default();
  app.add_option("--without", o.without, "sensor that is silent")
      .one_of({"nothing", "laser", "radar", "gyro", "wheels"})
      .show_default();
  app.add_option("--runs", o.runs, "runs, one per seed").range(1, 1000).show_default();
  app.add_option("--seed", o.first_seed, "of the random numbers, for the first run").show_default();
  app.add_option("--speed", o.speed_m_s, "largest speed, m/s").range(0.05, 2.0).show_default();
  app.add_number("--doppler-bins", o.doppler_bins, 16, 256,
                 "of the radar, a power of two: the smaller its bins of speed");
  app.add_number("--outliers", o.outliers, 0.0, 0.5,
                 "share of wheel samples and radar frames that are wrong");
  app.add_flag("--quiet", o.quiet, "print no progress");
  app.example("--runs 10", "ten robots");
  if (const auto code = app.parse(argc, argv)) return *code;
  return exit_code("calibration_study", run(o));
}
