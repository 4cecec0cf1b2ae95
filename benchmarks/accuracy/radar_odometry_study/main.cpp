// Odometry and radar SLAM with wheels, slipping wheels and without wheels, each with and without
// the radar's velocity, in a simulated world over seeds.

#include <algorithm>
#include <cstdio>
#include <string>
#include <vector>

#include <wayfare/eval/trajectory_error.hpp>
#include <wayfare/sensors/trajectory.hpp>
#include <wayfare/sim/worlds.hpp>
#include <wayfare/slam/radar_slam.hpp>
#include <wayfare/sync/radar_odometry.hpp>

#include "support/plans.hpp"
#include "support/program_files.hpp"
#include "support/progress_line.hpp"
#include "support/slam_program.hpp"

namespace {

using namespace wayfare;
using namespace wayfare::examples;

struct Options {
  std::string world = "corridor_loop", sensors = "radar";
  int runs = 5;
  std::uint64_t first_seed = 1;
  std::size_t particles = 10;
  int threads = 1;
};

/// About one of every four seconds a wheel, or both, turns on the spot faster than it rolls.
void slip(Recording& r, std::uint64_t seed) {
  Rng rng = Rng(seed).stream(5);
  LogTime until = r.wheels.front().time;
  double left = 1.0, right = 1.0;
  for (WheelSample& w : r.wheels) {
    if (w.time >= until) {
      const bool slips = left == 1.0 && right == 1.0;
      until = w.time + from_seconds(slips ? rng.uniform(1.0, 4.0) : rng.uniform(3.0, 12.0));
      const double which = rng.uniform();
      left = slips && which < 0.7 ? rng.uniform(1.3, 2.5) : 1.0;
      right = slips && which > 0.3 ? rng.uniform(1.3, 2.5) : 1.0;
    }
    w.left_m *= left, w.right_m *= right;
  }
}

/// Odometry of the wheels with the gyro's heading, as a robot with both has it.
void reckon(Recording& r) {
  r.odometry.clear();
  if (!r.wheels.empty()) r.odometry = sim::dead_reckon(r.wheels, r.gyro);
}

struct Case {
  std::string wheels;
  bool radar;
};

struct Series {
  std::vector<double> odometry_m, odometry_end_m, x, y, heading, end;
  std::vector<std::uint64_t> seeds;
  std::size_t failed = 0;
  double replaced_s = 0.0;
};

Recording recording_of(const Recording& good, const Case& c, std::uint64_t seed, Series& s) {
  Recording r = good;
  if (c.wheels == "missing") r.wheels.clear();
  if (c.wheels == "slipping") slip(r, seed);
  reckon(r);
  if (!c.radar) return r;
  const RadarOdometry found = radar_odometry(r);
  s.replaced_s += found.slipped_s + found.silent_s;
  return with_radar_odometry(std::move(r));
}

void run_case(const Recording& good, const Case& c, const Options& o, std::uint64_t seed,
              Series& s) {
  const Recording r = recording_of(good, c, seed, s);
  const eval::AbsoluteOptions from_start{eval::Alignment::start, {}, true};
  if (!r.odometry.empty()) {
    const auto e = eval::absolute_error(as_trajectory(r.odometry), r.truth, from_start);
    s.odometry_m.push_back(e.translation_m.rmse);
    s.odometry_end_m.push_back(e.end_m);
  }
  RadarSlamOptions options;
  options.particles = o.particles;
  options.seed = seed;
  options.threads = o.threads;
  const auto slam = run_radar_slam(r, options,
                                   o.sensors == "radar"   ? SlamSensors::radar
                                   : o.sensors == "lidar" ? SlamSensors::lidar
                                                          : SlamSensors::both);
  if (!slam) {
    ++s.failed;
    return;
  }
  const auto e = eval::absolute_error(slam->trajectory, r.truth, from_start);
  s.x.push_back(e.rmse_x_m), s.y.push_back(e.rmse_y_m), s.heading.push_back(e.rmse_heading_deg);
  s.end.push_back(e.end_m), s.seeds.push_back(seed);
  std::fprintf(stderr, "seed %d %s%s: odometry %.2f m, SLAM %.3f %.3f m, %.2f deg, end %.3f m\n",
               static_cast<int>(seed), c.wheels.c_str(), c.radar ? " with radar" : "",
               s.odometry_m.empty() ? -1.0 : s.odometry_m.back(), e.rmse_x_m, e.rmse_y_m,
               e.rmse_heading_deg, e.end_m);
}

std::string worst(const std::vector<double>& values) {
  return values.empty() ? "–" : eval::fixed(*std::ranges::max_element(values), 3);
}

Result<void> run(const Options& o) {
  const std::vector<Case> cases{{"good", false},    {"good", true},     {"slipping", false},
                                {"slipping", true}, {"missing", false}, {"missing", true}};
  std::vector<Series> all(cases.size());
  for (int i = 0; i < o.runs; ++i) {
    const std::uint64_t seed = o.first_seed + static_cast<std::uint64_t>(i);
    const Rng rng(seed);
    const auto world = sim::make_world(o.world, rng);
    if (!world) return world.error();
    const auto good = sim::simulate_world(*world, sim::turtlebot(rng), rng);
    if (!good) return good.error();
    for (std::size_t k = 0; k < cases.size(); ++k) run_case(*good, cases[k], o, seed, all[k]);
  }
  eval::Table table({{"wheels, radar velocity"},
                     {"odometry", "m"},
                     {"worst", "m"},
                     {"at its end", "m"},
                     {"SLAM x", "m"},
                     {"SLAM y", "m"},
                     {"worst x or y", "m"},
                     {"heading", "deg"},
                     {"at the end", "m"},
                     {"replaced", "s"},
                     {"no result"}});
  for (std::size_t k = 0; k < cases.size(); ++k) {
    const Series& s = all[k];
    std::vector<double> larger;
    for (std::size_t i = 0; i < s.x.size(); ++i) larger.push_back(std::max(s.x[i], s.y[i]));
    table.add_row({cases[k].wheels + (cases[k].radar ? ", yes" : ", no"),
                   eval::mean_std(s.odometry_m, 2), worst(s.odometry_m),
                   eval::mean_std(s.odometry_end_m, 2), eval::mean_std(s.x, 3),
                   eval::mean_std(s.y, 3), worst(larger), eval::mean_std(s.heading, 2),
                   eval::mean_std(s.end, 3), eval::fixed(s.replaced_s / o.runs, 1),
                   std::to_string(s.failed)});
  }
  std::printf("%s", table.to_text().c_str());
  return {};
}

}  // namespace

int main(int argc, char** argv) {
  CommandLine app(
      "Run odometry and radar SLAM in a simulated world with good, slipping and missing wheels, "
      "each with and without the radar's velocity, and print the errors over seeds.");
  Options o;
  app.add_option("--world", o.world, "a world of simulate").one_of(world_names()).show_default();
  app.add_option("--sensors", o.sensors, "radar, lidar or both").one_of({"radar", "lidar", "both"});
  app.add_option("--runs", o.runs, "runs, one per seed").range(1, 1000).show_default();
  app.add_option("--seed", o.first_seed, "of the random numbers, for the first run").show_default();
  app.add_option("--particles", o.particles, "of the filter").range(1, 100000).show_default();
  add_threads(app, o.threads);
  app.example("--runs 5", "five seeds in the corridor loop");
  if (const auto code = app.parse(argc, argv)) return *code;
  return exit_code("radar_odometry_study", run(o));
}
