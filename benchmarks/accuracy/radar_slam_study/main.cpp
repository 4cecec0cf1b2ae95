// SLAM with radar, LiDAR and both in a simulated world, over many seeds of world, robot and filter.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <span>
#include <string>
#include <vector>

#include <wayfare/eval/trajectory_error.hpp>
#include <wayfare/sensors/trajectory.hpp>
#include <wayfare/sim/worlds.hpp>
#include <wayfare/slam/radar_slam.hpp>

#include "support/plans.hpp"
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
  std::size_t particles = RadarSlamOptions{}.particles;
  int threads = 1;
  double slant_deg = 0.0;
  std::size_t walkers = 0;
  double lidar_range_m = 0.0;
  double moving_m_s = 0.18;
};

SlamSensors sensors_of(const std::string& name) {
  return name == "radar"   ? SlamSensors::radar
         : name == "lidar" ? SlamSensors::lidar
                           : SlamSensors::both;
}

/// Normalised squared error of the last pose, by the filter's covariance; three degrees of freedom.
double nees_at_end(const RadarSlamRun& run, const Trajectory& truth) {
  const StampedPose& last = run.trajectory.back();
  const SE2d expected =
      truth.front().T_map_base.raw().inverse() * sim::true_pose_at(truth, last.time);
  const Eigen::Vector3d off = expected.minus(last.T_map_base.raw());
  return off.dot(run.covariance.ldlt().solve(off));
}

struct Series {
  std::string name;
  std::vector<double> x, y, heading, end, largest, took, nees;
  std::vector<std::uint64_t> seeds;

  void add(std::uint64_t seed, const eval::AbsoluteError& e, double took_s, double nees_at_end) {
    seeds.push_back(seed);
    x.push_back(e.rmse_x_m);
    y.push_back(e.rmse_y_m);
    heading.push_back(e.rmse_heading_deg);
    end.push_back(e.end_m);
    largest.push_back(e.translation_m.max);
    took.push_back(took_s);
    nees.push_back(nees_at_end);
  }
  /// The larger of both axes' errors.
  [[nodiscard]] double error(std::size_t i) const { return std::max(x[i], y[i]); }
  [[nodiscard]] std::size_t worst() const {
    std::size_t worst = 0;
    for (std::size_t i = 1; i < x.size(); ++i)
      if (error(i) > error(worst)) worst = i;
    return worst;
  }
  void row(eval::Table& table) const {
    const auto closed = std::ranges::count_if(end, [](double e) { return e <= 0.5; });
    table.add_row({name, eval::mean_std(x, 3), eval::mean_std(y, 3),
                   eval::fixed(error(worst()), 3) + " (" + std::to_string(seeds[worst()]) + ")",
                   eval::mean_std(heading, 2), eval::mean_std(end, 3),
                   std::to_string(closed) + " of " + std::to_string(end.size()),
                   eval::mean_std(largest, 3), took.front() > 0.0 ? eval::mean_std(nees, 1) : "",
                   eval::mean_std(took, 1)});
  }
};

/// How much worse the series named both is than the better single sensor, over the seeds.
void print_comparison(std::span<const Series> all) {
  const auto find = [&](const char* name) { return std::ranges::find(all, name, &Series::name); };
  const auto radar = find("radar"), lidar = find("lidar"), both = find("both");
  if (radar == all.end() || lidar == all.end() || both == all.end()) return;
  std::size_t most = 0;
  const auto loss = [&](std::size_t i) {
    return both->error(i) - std::min(radar->error(i), lidar->error(i));
  };
  for (std::size_t i = 1; i < both->x.size(); ++i)
    if (loss(i) > loss(most)) most = i;
  std::printf("both less the better single sensor: at most %.3f m (seed %llu)\n", loss(most),
              static_cast<unsigned long long>(both->seeds[most]));
}

/// Adds a first leg at an angle to the next: the map's axes are those of the robot's first heading.
void slant(sim::World& world, Angle angle) {
  constexpr double kLeg_m = 1.1;
  const Eigen::Vector2d leg = (world.route_m[1] - world.route_m[0]).normalized();
  world.route_m.insert(world.route_m.begin(), world.route_m[0] - kLeg_m * (SO2d(angle) * leg));
}

Result<void> run(const Options& o) {
  std::vector<Series> all(1 + o.sensors.size());
  all[0].name = "odometry";
  for (std::size_t k = 0; k < o.sensors.size(); ++k) all[k + 1].name = o.sensors[k];
  for (int i = 0; i < o.runs; ++i) {
    const std::uint64_t seed = o.first_seed + static_cast<std::uint64_t>(i);
    const Rng rng(seed);
    auto world = sim::make_world(o.world, rng);
    if (!world) return world.error();
    if (o.slant_deg != 0.0) slant(*world, Angle::degrees(o.slant_deg));
    constexpr std::uint64_t kPeople = 77;  // a random stream of their own
    for (const sim::Walker& w : sim::walkers_along(world->route_m, o.walkers, rng.stream(kPeople)))
      world->walkers.push_back(w);
    sim::WorldRobot robot = sim::turtlebot(rng);
    if (o.lidar_range_m > 0.0) robot.robot.lidar.max_range_m = o.lidar_range_m;
    const auto recording = sim::simulate_world(*world, robot, rng);
    if (!recording) return recording.error();
    const eval::AbsoluteOptions from_start{eval::Alignment::start, {}, true};
    all[0].add(
        seed,
        eval::absolute_error(as_trajectory(recording->odometry), recording->truth, from_start), 0.0,
        0.0);
    for (std::size_t k = 1; k < all.size(); ++k) {
      RadarSlamOptions options;
      options.particles = o.particles;
      options.seed = seed;
      options.threads = o.threads;
      ProgressLine timer(all[k].name, true);
      SyncParams sync;
      sync.moving_m_s = o.moving_m_s;
      const auto slam = run_radar_slam(*recording, options, sensors_of(all[k].name), {}, {}, sync);
      if (!slam) return slam.error();
      const double took_s = timer.finish();
      const auto e = eval::absolute_error(slam->trajectory, recording->truth, from_start);
      const double nees = nees_at_end(*slam, recording->truth);
      all[k].add(seed, e, took_s, nees);
      std::fprintf(stderr, "seed %d %s: %.3f %.3f m %.2f deg, at the end %.3f m, NEES %.1f\n",
                   static_cast<int>(seed), all[k].name.c_str(), e.rmse_x_m, e.rmse_y_m,
                   e.rmse_heading_deg, e.end_m, nees);
    }
  }
  eval::Table table({{o.world},
                     {"RMSE x", "m"},
                     {"RMSE y", "m"},
                     {"worst x or y", "m (seed)"},
                     {"heading", "deg"},
                     {"at the end", "m"},
                     {"within 0.5 m"},
                     {"largest", "m"},
                     {"NEES, mean"},
                     {"took", "s"}});
  for (const Series& s : all) s.row(table);
  std::printf("%s", table.to_text().c_str());
  print_comparison(all);
  return {};
}

}  // namespace

int main(int argc, char** argv) {
  CommandLine app(
      "Run radar SLAM in a simulated world over many seeds and print mean and standard deviation "
      "of its errors; trajectories start at the true pose, without further alignment.");
  Options o;
  app.add_option("WORLD", o.world, "a world of simulate").one_of(world_names()).required();
  app.add_option("--sensors", o.sensors, "radar, lidar, both").one_of({"radar", "lidar", "both"});
  app.add_option("--runs", o.runs, "runs, one per seed").range(1, 1000).show_default();
  app.add_option("--seed", o.first_seed, "of the random numbers, for the first run").show_default();
  app.add_option("--particles", o.particles, "of the filter").range(1, 100000).show_default();
  app.add_option("--slant", o.slant_deg,
                 "degrees between a first leg and the route: the map's axes")
      .range(-60.0, 60.0)
      .show_default();
  app.add_option("--walkers", o.walkers, "people who walk beside the route")
      .range(0, 1000)
      .show_default();
  app.add_option("--lidar-range", o.lidar_range_m, "of the LiDAR, m; 0: the Turtlebot's")
      .range(0.0, 1000.0)
      .show_default();
  app.add_option("--moving", o.moving_m_s,
                 "m/s of radial speed by which a radar point differs from a static one to be left "
                 "out; 0: never")
      .range(0.0, 100.0)
      .show_default();
  add_threads(app, o.threads);
  app.example("room --sensors radar --runs 10", "ten seeds in one world");
  if (const auto code = app.parse(argc, argv)) return *code;
  return exit_code("radar_slam_study", run(o));
}
