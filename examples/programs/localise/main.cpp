// Finds a robot on a known map from its log: poses, how far they are to be believed, and a report.

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <wayfare/io/map_image.hpp>
#include <wayfare/io/tum.hpp>
#include <wayfare/slam/localisation.hpp>

#include "outputs.hpp"
#include "support/command_line.hpp"
#include "support/exit_code.hpp"
#include "support/program_files.hpp"
#include "support/progress_line.hpp"
#include "support/slam_program.hpp"

namespace {

using namespace wayfare;

struct Options : examples::SlamArguments {
  std::string map, radar_map, truth, sensors;
  std::vector<double> initial;  // x, y, heading
  bool global = false, beam = false;
  LocalisationOptions localisation;
  LocalisationMapOptions map_options;
};

/// A picture's cells in the frame of another picture's lower left corner.
OccupancyGrid grid_of(const io::GridImage& image, const SE2d& T_grid_image) {
  OccupancyGrid grid({.resolution_m = image.resolution_m});
  for (std::size_t row = 0; row < image.height; ++row)
    for (std::size_t column = 0; column < image.width; ++column) {
      const auto p = static_cast<double>(image.occupancy[row * image.width + column]);
      if (std::isnan(p)) continue;
      const Eigen::Vector2d centre(static_cast<double>(column) + 0.5,
                                   static_cast<double>(row) + 0.5);
      grid.update(cell_of(T_grid_image * (image.resolution_m * centre), image.resolution_m),
                  LogOdds::from_probability(std::clamp(p, 0.001, 0.999)));
    }
  return grid;
}

struct Maps {
  io::GridImage image;
  std::shared_ptr<const LocalisationMap> map;
};

/// The maps, as cells from the lower left corner of the one of walls on; their frame's pose is that
/// picture's origin.
Result<Maps> read_maps(const Options& o) {
  auto image = io::read_map(o.map);
  if (!image) return image.error();
  std::optional<OccupancyGrid> radar;
  if (!o.radar_map.empty() && o.sensors != "lidar") {
    const auto seen = io::read_map(o.radar_map);
    if (!seen) return seen.error();
    radar = grid_of(*seen, image->origin.inverse() * seen->origin);
    if (!radar->bounds()) return Error{ErrorCode::invalid, "the map is empty", o.radar_map};
  }
  const auto map =
      LocalisationMap::make(grid_of(*image, SE2d()), o.map_options, radar ? &*radar : nullptr);
  if (!map) return Error{map.error().code, map.error().message, o.map};
  return Maps{*std::move(image), *map};
}

Result<Trajectory> truth_of(const Options& o, const Recording& recording) {
  if (o.truth.empty()) return recording.truth;
  auto file = io::read_tum(o.truth);
  if (!file) return file.error();
  examples::print_problems(file->problems);
  return io::planar(file->trajectory);
}

std::optional<Gaussian<SE2d>> start_of(const Options& o, const SE2d& T_map_grid) {
  if (o.initial.empty()) return std::nullopt;
  const SE2d pose(o.initial[0], o.initial[1], Angle::radians(o.initial[2]));
  return Gaussian<SE2d>{T_map_grid.inverse() * pose,
                        Eigen::Vector3d(0.25, 0.25, 0.07).asDiagonal()};
}

/// From the picture's corner to the map's frame.
void move_to_map(LocalisationRun& run, const SE2d& T_map_grid) {
  for (LocalisationOutcome& s : run.outcomes) s.T_map_base.mean = T_map_grid * s.T_map_base.mean;
  for (ParticleSnapshot& shot : run.snapshots)
    for (PoseParticle& p : shot.particles) p.T_map_base = T_map_grid * p.T_map_base;
}

struct TimedRun {
  LocalisationRun run;
  double took_s = 0.0;
};

Result<TimedRun> localise(const Options& o, const Maps& maps, const Recording& recording) {
  examples::ProgressLine progress("localising", o.quiet);
  LocalisationControl control;
  control.snapshots_at = {0.0, 0.005, 0.02, 0.1, 0.5, 1.0};
  control.progress = [&](double fraction) {
    progress.update(fraction);
    return true;
  };
  const auto began = std::chrono::steady_clock::now();
  auto run = run_localisation(recording, maps.map, o.localisation, o.seed,
                              start_of(o, maps.image.origin), control);
  if (!run) return Error{run.error().code, run.error().message, o.log};
  progress.finish();
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - began;
  move_to_map(*run, maps.image.origin);
  return TimedRun{*std::move(run), took.count()};
}

std::string belief_of(const LocalisationOutcome& last) {
  if (last.particles == 0) return "nothing was seen to go by";
  if (last.converged)
    return "believed, with " + eval::fixed(100.0 * last.mass, 0) + " % of the weight";
  if (last.clusters > 1)
    return "not believed: " + std::to_string(last.clusters) + " places are left";
  return "not believed: what is seen does not fit";
}

std::vector<std::pair<std::string, std::string>> facts_of(const TimedRun& timed) {
  const auto& outcomes = timed.run.outcomes;
  std::size_t believed = 0, searches = 0, moves = 0, odometry = 0, weighed = 0, radar = 0;
  std::string first = "never";
  for (const LocalisationOutcome& s : outcomes) {
    if (s.converged && believed++ == 0)
      first = "after " + eval::fixed(to_seconds(s.time - outcomes.front().time), 1) + " s";
    searches += s.searched ? 1 : 0;
    moves += s.relocalised ? 1 : 0;
    odometry += s.odometry_refused ? 1 : 0;
    weighed += s.weighed ? 1 : 0;
    radar += s.sensor == RangeSensor::radar ? 1 : 0;
  }
  const LocalisationOutcome& last = outcomes.back();
  const double lasts_s = to_seconds(last.time - outcomes.front().time);
  return {{"scans", std::to_string(outcomes.size()) + " (" + std::to_string(radar) +
                        " of radar), " + std::to_string(weighed) + " weighed"},
          {"first believed", first},
          {"believed",
           eval::fixed(100.0 * static_cast<double>(believed) / static_cast<double>(outcomes.size()),
                       1) +
               " % of the scans"},
          {"at the end", belief_of(last)},
          {"searches", std::to_string(searches) + ", found elsewhere " + std::to_string(moves)},
          {"refused", std::to_string(timed.run.refused_scans) + " scans, odometry at " +
                          std::to_string(odometry)},
          {"took", examples::speed(timed.took_s, lasts_s, 2)}};
}

Result<void> run(const Options& o) {
  if (!std::isfinite(o.localisation.max_range_m))
    return Error{ErrorCode::invalid, "--max-range must be a number"};
  if (!std::all_of(o.initial.begin(), o.initial.end(), [](double v) { return std::isfinite(v); }))
    return Error{ErrorCode::invalid, "--initial must be three numbers"};
  if (o.sensors != "lidar" && !o.sensors.empty() && o.radar_map.empty())
    return Error{ErrorCode::invalid, "listening to radar takes a --radar-map"};
  const auto maps = read_maps(o);
  if (!maps) return maps.error();
  const auto recording = examples::read_robot_log(o.log, o.topics);
  if (!recording) return recording.error();
  const auto truth = truth_of(o, *recording);
  if (!truth) return truth.error();
  if (auto ready = examples::prepare_files(o.out, examples::localisation_files(), o.write());
      !ready)
    return ready;
  const auto timed = localise(o, *maps, *recording);
  if (!timed) return timed.error();
  if (timed->run.refused_scans > 0)
    std::fprintf(stderr, "%zu scans refused, the first: %s\n", timed->run.refused_scans,
                 timed->run.first_refusal.c_str());
  const examples::LocalisationOutputs outputs{"Localisation of " + o.log + " on " + o.map,
                                              maps->image, timed->run, *truth, facts_of(*timed)};
  const auto report = examples::write_localisation(o.out, outputs, o.write());
  if (!report) return report.error();
  if (o.quiet) return {};
  for (const auto& [name, value] : outputs.facts)
    std::printf("%-14s %s\n", name.c_str(), value.c_str());
  if (!truth->empty())
    std::printf("\n%s", examples::localisation_errors(outputs).to_text().c_str());
  std::printf("\nreport: %s\n", report->c_str());
  return {};
}

void add_options(examples::CommandLine& app, Options& o) {
  app.add_option("LOG", o.log, std::string("the recorded log: ") + examples::kRobotLogs)
      .required()
      .existing_file();
  app.add_option("MAP", o.map, "the .yaml file of a map, as map_server and graph_slam write it")
      .required()
      .existing_file();
  examples::add_out(app, o, "folder for the results, made where needed");
  app.add_option("--radar-map", o.radar_map,
                 "the .yaml file of a map of what radar sees, as radar_slam writes it beside MAP: "
                 "the log's radar is then listened to as well")
      .existing_file();
  app.add_option("--sensors", o.sensors, "lidar, radar or both; else what there are maps for")
      .one_of({"lidar", "radar", "both"});
  app.add_option("--initial", o.initial,
                 "x,y,heading in the map, m and rad: where the robot starts, give or take half a "
                 "metre and 15 degrees")
      .delimiter(',')
      .expected(3);
  app.add_flag("--global", o.global, "look for it all over the map (so too without --initial)")
      .excludes("--initial");
  app.add_option("--truth", o.truth,
                 "TUM trajectory in the map's frame to measure by; without it the log's own truth")
      .existing_file();
  app.add_flag("--beam", o.beam, "the beam model instead of the likelihood field");
  app.add_option("--beams", o.localisation.beams, "beams of a scan that are looked at")
      .range(4, 10000)
      .show_default();
  app.add_option("--max-range", o.localisation.max_range_m, "farther returns are left out, m")
      .positive()
      .show_default();
  app.add_option("--particles", o.localisation.max_particles, "at most so many")
      .range(100, 10000000)
      .show_default();
  app.add_option("--sigma", o.map_options.lidar.sigma_m, "of a range about the wall it measures, m")
      .positive()
      .show_default();
  examples::add_seed(app, o, "the same seed gives the same results");
  examples::add_threads(app, o);
  examples::add_robot_topics(app, o.topics);
  examples::add_manners(app, o);
}

}  // namespace

int main(int argc, char** argv) {
  examples::CommandLine app(
      "Find a robot on a known map from its log of scans and odometry, by Monte-Carlo "
      "localisation on LiDAR, radar or both.\nWrites trajectory.tum (the poses believed), "
      "poses.csv (every scan) and "
      "report.html.");
  Options o;
  add_options(app, o);
  if (const auto code = app.parse(argc, argv)) return *code;
  if (o.beam) o.localisation.model = ScanLikelihood::beam;
  o.localisation.use_lidar = o.sensors != "radar";
  o.localisation.threads = o.threads;
  return examples::exit_code("localise", run(o));
}
