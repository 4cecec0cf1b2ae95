// Covariances of the latest pose against the truth of simulated drives: normalised squared errors
// (NEES) of the systems, over seeds.

#include <algorithm>
#include <cstdint>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include <wayfare/eval/pose_consistency.hpp>
#include <wayfare/eval/table.hpp>
#include <wayfare/sim/worlds.hpp>
#include <wayfare/slam/hector_slam.hpp>
#include <wayfare/slam/radar_slam.hpp>
#include <wayfare/slam/submap_slam.hpp>
#include <wayfare/sync/odometry_track.hpp>

#include "support/plans.hpp"
#include "support/program_files.hpp"
#include "support/progress_line.hpp"

namespace {

using namespace wayfare;
using namespace wayfare::examples;
using eval::PoseConsistency;

constexpr std::size_t kEvery = 5;  // scans between poses that are compared

struct Options {
  std::vector<std::string> worlds;
  int runs = 10;
  std::uint64_t first = 1;
  double lidar_range_m = 0.0;
  int submap_nodes = 0;
  std::string only;
  bool no_odometry = false, quiet = false;
};

Result<sim::World> world_of(const std::string& name, const Rng& rng) {
  if (is_world(name)) return sim::make_world(name, rng);
  auto planned = read_any_plan(name);
  if (!planned) return planned.error();
  return sim::furnished_world(std::move(planned->plan), std::move(planned->route_m), {}, {}, rng);
}

Result<Recording> drive_through(const Options& o, const std::string& name, std::uint64_t seed) {
  const Rng rng(seed);
  auto world = world_of(name, rng);
  if (!world) return world.error();
  sim::WorldRobot robot = sim::turtlebot(rng);
  if (o.lidar_range_m > 0.0) robot.robot.lidar.max_range_m = o.lidar_range_m;
  auto recording = sim::simulate_world(*world, robot, rng);
  if (recording && o.no_odometry) recording->odometry.clear();
  return recording;
}

template <class Slam, class Options, class Hint>
Result<void> follow(const Recording& recording, Options options, const Hint& hint,
                    PoseConsistency& found) {
  options.T_base_laser = recording.T_base_laser;
  Slam slam(options);
  const OdometryTrack odometry(recording.odometry);
  for (std::size_t i = 0; i < recording.scans.size(); ++i) {
    const LaserScan& scan = recording.scans[i];
    const auto outcome = slam.add_scan(scan, hint(odometry.at(scan.time)));
    if (!outcome) return outcome.error();
    if (i % kEvery == 0) found.add(scan.time, outcome->T_map_base.raw(), slam.covariance());
  }
  return {};
}

Result<void> follow_by_particles(const Recording& recording, SlamSensors sensors,
                                 PoseConsistency& found) {
  RadarSlamStreamOptions options;
  options.sensors = sensors;
  options.slam.particles = 10;
  options.slam.T_base_laser = recording.T_base_laser;
  options.sync.T_base_radar = recording.T_base_radar;
  RadarSlamStream stream(options);
  for (const auto& s : recording.odometry) stream.add(s);
  for (const auto& s : recording.scans) stream.add(s);
  for (const auto& s : recording.radar) stream.add(s);
  stream.finish();
  std::size_t poses = 0;
  while (const auto time = stream.step()) {
    const auto pose = stream.slam().pose();
    if (pose && pose->time == *time && poses++ % kEvery == 0)
      found.add(*time, pose->T_map_base.raw(), stream.slam().covariance());
  }
  return {};
}

struct System {
  std::string name;
  std::function<Result<void>(const Recording&, PoseConsistency&)> follow;
};

std::vector<System> systems_of(const Options& o) {
  std::vector<System> all{{"submaps",
                           [&o](const Recording& r, PoseConsistency& found) {
                             SubmapSlamOptions options;
                             if (o.submap_nodes > 0) options.submap_nodes = o.submap_nodes;
                             return follow<SubmapSlam>(
                                 r, options,
                                 [](const auto& odometry) {
                                   return MotionHint{odometry, {}};
                                 },
                                 found);
                           }},
                          {"hector", [](const Recording& r, PoseConsistency& found) {
                             return follow<HectorSlam>(
                                 r, HectorSlamOptions(),
                                 [](const auto& odometry) { return odometry; }, found);
                           }}};
  for (const auto& [name, sensors] : {std::pair{"particles lidar", SlamSensors::lidar},
                                      {"particles radar", SlamSensors::radar},
                                      {"particles both", SlamSensors::both}})
    all.push_back({name, [sensors = sensors](const Recording& r, PoseConsistency& found) {
                     return follow_by_particles(r, sensors, found);
                   }});
  std::erase_if(all, [&](const System& s) { return s.name.find(o.only) == std::string::npos; });
  return all;
}

/// Over the drives of a world.
struct Means {
  eval::IndependentMean nees, error_m, sigma_m, error_deg, sigma_deg;
  double largest = 0.0;

  void add(const PoseConsistency& c) {
    nees.add(c.mean_nees());
    error_m.add(c.error_m());
    sigma_m.add(c.sigma_m());
    error_deg.add(Angle::radians(c.error_rad()).degrees());
    sigma_deg.add(Angle::radians(c.sigma_rad()).degrees());
    largest = std::max(largest, c.largest_nees());
  }
  [[nodiscard]] std::vector<std::string> row(const std::string& world,
                                             const std::string& system) const {
    return {world,
            system,
            eval::fixed(nees.mean(), 2),
            eval::fixed(nees.deviation(), 2),
            eval::fixed(largest, 1),
            eval::fixed(error_m.mean(), 3),
            eval::fixed(sigma_m.mean(), 3),
            eval::fixed(error_deg.mean(), 2),
            eval::fixed(sigma_deg.mean(), 2)};
  }
};

Result<void> run(const Options& o) {
  const std::vector<System> systems = systems_of(o);
  eval::Table table{{{"world"},
                     {"system"},
                     {"NEES"},
                     {"deviation"},
                     {"largest"},
                     {"error", "m"},
                     {"sigma", "m"},
                     {"error", "deg"},
                     {"sigma", "deg"}}};
  for (const std::string& world : o.worlds) {
    ProgressLine progress(world, o.quiet);
    std::vector<Means> means(systems.size());
    for (int k = 0; k < o.runs; ++k) {
      const auto recording = drive_through(o, world, o.first + static_cast<std::uint64_t>(k));
      if (!recording) return recording.error();
      for (std::size_t s = 0; s < systems.size(); ++s) {
        PoseConsistency found(recording->truth);
        if (auto ok = systems[s].follow(*recording, found); !ok) return ok;
        means[s].add(found);
        progress.update((k + static_cast<double>(s + 1) / static_cast<double>(systems.size())) /
                        o.runs);
      }
    }
    progress.finish();
    for (std::size_t s = 0; s < systems.size(); ++s)
      table.add_row(means[s].row(world, systems[s].name));
  }
  std::fputs(table.to_text().c_str(), stdout);
  return {};
}

}  // namespace

int main(int argc, char** argv) {
  CommandLine app(
      "Are the covariances of the latest pose as large as its errors? Normalised squared errors "
      "(NEES) of every fifth pose of simulated drives, mean and standard deviation over seeds, "
      "and the largest: a consistent system has 3, more is too optimistic. Beside them the root "
      "mean squares of errors and covariances.");
  Options o;
  app.add_option("WORLD", o.worlds, "simulated worlds, or floor plans").required();
  app.add_option("--runs", o.runs, "drives, one per seed").range(1, 1000).show_default();
  app.add_option("--seed", o.first, "of the random numbers, for the first drive").show_default();
  app.add_option("--only", o.only, "the systems with this in their name");
  app.add_option("--lidar-range", o.lidar_range_m, "of the LiDAR, m; 0: the Turtlebot's")
      .range(0.0, 1000.0)
      .show_default();
  app.add_option("--submap-nodes", o.submap_nodes, "scans to a submap; 0: as many as by default")
      .range(0, 10000)
      .show_default();
  app.add_flag("--no-odometry", o.no_odometry, "by scans alone");
  app.add_flag("--quiet", o.quiet, kQuietHelp);
  app.example("corridor_loop --runs 5 --only hector", "one system in one world");
  if (const auto code = app.parse(argc, argv)) return *code;
  return exit_code("covariance_study", run(o));
}
