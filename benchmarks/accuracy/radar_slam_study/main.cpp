// SLAM with radar, LiDAR and both in a simulated world, over many seeds of world, robot and filter.

#include <cstdio>
#include <string>
#include <vector>

#include <wayfare/eval/trajectory_error.hpp>
#include <wayfare/sensors/trajectory.hpp>
#include <wayfare/sim/worlds.hpp>
#include <wayfare/slam/radar_slam.hpp>

#include "support/program_files.hpp"
#include "support/progress_line.hpp"
#include "support/slam_program.hpp"

namespace {

using namespace wayfare;
using namespace wayfare::examples;

struct Options {
  std::string world = "room";
  std::vector<std::string> sensors{"radar", "lidar", "both"};
  int runs = 10;
  std::uint64_t first_seed = 1;
  std::size_t particles = 10;
  int threads = 1;
};

SlamSensors sensors_of(const std::string& name) {
  return name == "radar"   ? SlamSensors::radar
         : name == "lidar" ? SlamSensors::lidar
                           : SlamSensors::both;
}

struct Series {
  std::string name;
  std::vector<double> x, y, heading, end, worst, took;

  void add(const eval::AbsoluteError& e, double took_s) {
    x.push_back(e.rmse_x_m);
    y.push_back(e.rmse_y_m);
    heading.push_back(e.rmse_heading_deg);
    end.push_back(e.end_m);
    worst.push_back(e.translation_m.max);
    took.push_back(took_s);
  }
  void row(eval::Table& table) const {
    table.add_row({name, eval::mean_std(x, 3), eval::mean_std(y, 3), eval::mean_std(heading, 2),
                   eval::mean_std(end, 3), eval::mean_std(worst, 3), eval::mean_std(took, 1)});
  }
};

Result<void> run(const Options& o) {
  std::vector<Series> all{{"odometry", {}, {}, {}, {}, {}, {}}};
  for (const std::string& s : o.sensors) all.push_back({s, {}, {}, {}, {}, {}, {}});
  for (int i = 0; i < o.runs; ++i) {
    const std::uint64_t seed = o.first_seed + static_cast<std::uint64_t>(i);
    const Rng rng(seed);
    const auto world = sim::make_world(o.world, rng);
    if (!world) return world.error();
    const auto recording = sim::simulate_world(*world, sim::turtlebot(rng), rng);
    if (!recording) return recording.error();
    const eval::AbsoluteOptions from_start{eval::Alignment::start, {}, true};
    all[0].add(
        eval::absolute_error(as_trajectory(recording->odometry), recording->truth, from_start),
        0.0);
    for (std::size_t k = 1; k < all.size(); ++k) {
      RadarSlamOptions options;
      options.particles = o.particles;
      options.seed = seed;
      options.threads = o.threads;
      ProgressLine timer(all[k].name, true);
      const auto slam = run_radar_slam(*recording, options, sensors_of(all[k].name));
      if (!slam) return slam.error();
      const double took_s = timer.finish();
      const auto e = eval::absolute_error(slam->trajectory, recording->truth, from_start);
      all[k].add(e, took_s);
      std::fprintf(stderr, "seed %d %s: %.3f %.3f m %.2f deg, at the end %.3f m\n",
                   static_cast<int>(seed), all[k].name.c_str(), e.rmse_x_m, e.rmse_y_m,
                   e.rmse_heading_deg, e.end_m);
    }
  }
  eval::Table table({{o.world},
                     {"RMSE x", "m"},
                     {"RMSE y", "m"},
                     {"heading", "deg"},
                     {"at the end", "m"},
                     {"largest", "m"},
                     {"took", "s"}});
  for (const Series& s : all) s.row(table);
  std::printf("%s", table.to_text().c_str());
  return {};
}

}  // namespace

int main(int argc, char** argv) {
  CommandLine app(
      "Run radar SLAM in a simulated world over many seeds and print mean and standard deviation "
      "of its errors; trajectories start at the true pose, without further alignment.");
  Options o;
  app.add_option("WORLD", o.world, "corridor_loop, room or cluttered_room").required();
  app.add_option("--sensors", o.sensors, "radar, lidar, both").one_of({"radar", "lidar", "both"});
  app.add_option("--runs", o.runs, "runs, one per seed").range(1, 1000).show_default();
  app.add_option("--seed", o.first_seed, "of the random numbers, for the first run").show_default();
  app.add_option("--particles", o.particles, "of the filter").range(1, 100000).show_default();
  add_threads(app, o.threads);
  app.example("room --sensors radar --runs 10", "ten seeds in one world");
  if (const auto code = app.parse(argc, argv)) return *code;
  return exit_code("radar_slam_study", run(o));
}
