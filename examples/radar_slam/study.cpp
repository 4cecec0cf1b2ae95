// Radar, LiDAR and both in a simulated world, over many seeds: world, robot and filter draw anew
// with each.

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include <wayfare/eval/interpolation.hpp>
#include <wayfare/eval/statistics.hpp>
#include <wayfare/eval/table.hpp>
#include <wayfare/sim/worlds.hpp>
#include <wayfare/system/radar_slam.hpp>

#include "exit_code.hpp"

namespace {

using namespace wayfare;

struct Options {
  std::string world = "room";
  std::vector<std::string> sensors{"radar", "lidar", "both"};
  int runs = 10;
  std::uint64_t first_seed = 1;
  std::size_t particles = 10;
  int threads = 1;
};

struct Errors {
  double x_m = 0, y_m = 0, heading_deg = 0, end_m = 0, worst_m = 0;
};

/// In the frame of the first pose: no correction after the fact.
Result<Errors> errors_of(const Trajectory& estimate, const Trajectory& truth) {
  Errors e;
  const auto end = eval::pose_at(truth, estimate.front().time);
  if (!end) return Error{ErrorCode::not_found, "the truth does not cover the run"};
  const SE2d T_map_truth = estimate.front().T_map_base.raw() * end->inverse();
  std::size_t n = 0;
  for (const StampedPose& p : estimate) {
    const auto at = eval::pose_at(truth, p.time);
    if (!at) continue;
    const SE2d is = T_map_truth * *at;
    const Eigen::Vector2d d = p.T_map_base.raw().translation() - is.translation();
    const double turn = (is.rotation().inverse() * p.T_map_base.raw().rotation()).angle().degrees();
    e.x_m += d.x() * d.x();
    e.y_m += d.y() * d.y();
    e.heading_deg += turn * turn;
    e.end_m = d.norm();
    e.worst_m = std::max(e.worst_m, d.norm());
    ++n;
  }
  for (double* v : {&e.x_m, &e.y_m, &e.heading_deg}) *v = std::sqrt(*v / static_cast<double>(n));
  return e;
}

SlamSensors sensors_of(const std::string& name) {
  return name == "radar"   ? SlamSensors::radar
         : name == "lidar" ? SlamSensors::lidar
                           : SlamSensors::both;
}

Trajectory odometry_of(const Recording& recording) {
  Trajectory t;
  for (const OdometrySample& s : recording.odometry)
    t.push_back({s.time, Transform2<frame::Map, frame::Base>(s.T_odom_base.raw())});
  return t;
}

struct Series {
  std::string name;
  std::vector<double> x, y, heading, end, worst, took;

  void add(const Errors& e, double took_s) {
    x.push_back(e.x_m);
    y.push_back(e.y_m);
    heading.push_back(e.heading_deg);
    end.push_back(e.end_m);
    worst.push_back(e.worst_m);
    took.push_back(took_s);
  }
  void row(eval::Table& table) const {
    const auto cell = [](const std::vector<double>& v, int decimals) {
      const auto s = eval::summarise(v);
      return eval::mean_std(s.mean, s.std, decimals);
    };
    table.add_row({name, cell(x, 3), cell(y, 3), cell(heading, 2), cell(end, 3), cell(worst, 3),
                   cell(took, 1)});
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
    const auto by_odometry = errors_of(odometry_of(*recording), recording->truth);
    if (!by_odometry) return by_odometry.error();
    all[0].add(*by_odometry, 0.0);
    for (std::size_t k = 1; k < all.size(); ++k) {
      RadarSlamOptions options;
      options.particles = o.particles;
      options.seed = seed;
      options.threads = o.threads;
      const auto start = std::chrono::steady_clock::now();
      const auto slam = run_radar_slam(*recording, options, sensors_of(all[k].name));
      if (!slam) return slam.error();
      const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start;
      const auto e = errors_of(slam->trajectory, recording->truth);
      if (!e) return e.error();
      all[k].add(*e, took.count());
      std::fprintf(stderr, "seed %d %s: %.3f %.3f m %.2f deg, at the end %.3f m\n",
                   static_cast<int>(seed), all[k].name.c_str(), e->x_m, e->y_m, e->heading_deg,
                   e->end_m);
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
  CLI::App app(
      "Run radar SLAM in a simulated world over many seeds and print mean and spread of its "
      "errors, both trajectories begun at the same pose and nothing aligned afterwards.");
  Options o;
  app.add_option("WORLD", o.world, "corridor_loop, room or cluttered_room")->required();
  app.add_option("--sensors", o.sensors, "radar, lidar, both")
      ->check(CLI::IsMember({"radar", "lidar", "both"}));
  app.add_option("--runs", o.runs, "seeds")->check(CLI::Range(1, 1000))->capture_default_str();
  app.add_option("--seed", o.first_seed, "the first of them")->capture_default_str();
  app.add_option("--particles", o.particles, "of the filter")
      ->check(CLI::Range(1, 100000))
      ->capture_default_str();
  app.add_option("--threads", o.threads, "worker threads; the results do not depend on them")
      ->check(CLI::Range(1, 256))
      ->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  return wayfare::examples::exit_code("radar_slam_study", run(o));
}
