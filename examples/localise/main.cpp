// Finds a robot on a known map from its log: poses, how far they are to be believed, and a report.

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>

#include <wayfare/io/carmen.hpp>
#include <wayfare/io/map_image.hpp>
#include <wayfare/io/tum.hpp>
#include <wayfare/system/localisation.hpp>

#include "exit_code.hpp"
#include "outputs.hpp"
#include "program_files.hpp"
#include "progress_line.hpp"
#include "slam_program.hpp"

namespace {

using namespace wayfare;

struct Options : examples::SlamArguments {
  std::string log, map, truth;
  std::vector<double> initial;  // x, y, heading
  bool global = false, beam = false;
  LocalisationOptions localisation;
  LocalisationMapOptions map_options;
};

/// The map as cells from its own lower left corner on; its frame's pose is the picture's origin.
OccupancyGrid grid_of(const io::GridImage& image) {
  OccupancyGrid grid({.resolution_m = image.resolution_m});
  for (std::size_t row = 0; row < image.height; ++row)
    for (std::size_t column = 0; column < image.width; ++column) {
      const auto p = static_cast<double>(image.occupancy[row * image.width + column]);
      if (std::isnan(p)) continue;
      grid.update({static_cast<int>(column), static_cast<int>(row)},
                  LogOdds::from_probability(std::clamp(p, 0.001, 0.999)));
    }
  return grid;
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

Result<TimedRun> localise(const Options& o, const io::GridImage& image,
                          const Recording& recording) {
  const auto map = LocalisationMap::make(grid_of(image), o.map_options);
  if (!map) return Error{map.error().code, map.error().message, o.map};
  examples::ProgressLine progress("localising", o.quiet);
  LocalisationControl control;
  control.snapshots_at = {0.0, 0.005, 0.02, 0.1, 0.5, 1.0};
  control.progress = [&](double fraction) {
    progress.update(fraction);
    return true;
  };
  const auto began = std::chrono::steady_clock::now();
  auto run =
      run_localisation(recording, *map, o.localisation, o.seed, start_of(o, image.origin), control);
  if (!run) return Error{run.error().code, run.error().message, o.log};
  progress.finish();
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - began;
  move_to_map(*run, image.origin);
  return TimedRun{*std::move(run), took.count()};
}

std::vector<std::pair<std::string, std::string>> facts_of(const TimedRun& timed,
                                                          const Recording& recording) {
  const auto& outcomes = timed.run.outcomes;
  std::size_t believed = 0, searches = 0, moves = 0, odometry = 0, weighed = 0;
  std::string first = "never";
  for (const LocalisationOutcome& s : outcomes) {
    if (s.converged && believed++ == 0)
      first = "after " + eval::fixed(to_seconds(s.time - outcomes.front().time), 1) + " s";
    searches += s.searched ? 1 : 0;
    moves += s.moved ? 1 : 0;
    odometry += s.odometry_refused ? 1 : 0;
    weighed += s.weighed ? 1 : 0;
  }
  const double lasts_s = to_seconds(recording.scans.back().time - recording.scans.front().time);
  return {{"scans", std::to_string(outcomes.size()) + ", " + std::to_string(weighed) + " weighed"},
          {"first believed", first},
          {"believed",
           eval::fixed(100.0 * static_cast<double>(believed) / static_cast<double>(outcomes.size()),
                       1) +
               " % of the scans"},
          {"searches", std::to_string(searches) + ", found elsewhere " + std::to_string(moves)},
          {"refused", std::to_string(timed.run.refused_scans) + " scans, odometry at " +
                          std::to_string(odometry)},
          {"took", examples::speed(timed.took_s, lasts_s, 2)}};
}

Result<void> run(const Options& o) {
  const auto image = io::read_map(o.map);
  if (!image) return image.error();
  auto log = io::read_carmen(o.log);
  if (!log) return log.error();
  examples::print_problems(log->problems);
  const auto truth = truth_of(o, log->recording);
  if (!truth) return truth.error();
  if (auto ready = examples::prepare_files(o.out, examples::localisation_files(), o.write());
      !ready)
    return ready;
  const auto timed = localise(o, *image, log->recording);
  if (!timed) return timed.error();
  if (timed->run.refused_scans > 0)
    std::fprintf(stderr, "%zu scans refused, the first: %s\n", timed->run.refused_scans,
                 timed->run.first_refusal.c_str());
  const examples::LocalisationOutputs outputs{"Localisation of " + o.log + " on " + o.map, *image,
                                              timed->run, *truth, facts_of(*timed, log->recording)};
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

void add_options(CLI::App& app, Options& o) {
  app.add_option("LOG", o.log, "the recorded log, CARMEN text, plain or gzip")
      ->required()
      ->check(CLI::ExistingFile);
  app.add_option("MAP", o.map, "the .yaml file of a map, as map_server and graph_slam write it")
      ->required()
      ->check(CLI::ExistingFile);
  examples::add_out(app, o, "folder for the results, made where needed");
  auto* initial = app.add_option("--initial", o.initial,
                                 "x,y,heading in the map, m and rad: where the robot starts, give "
                                 "or take half a metre and 15 degrees")
                      ->delimiter(',')
                      ->expected(3);
  app.add_flag("--global", o.global, "look for it all over the map (so too without --initial)")
      ->excludes(initial);
  app.add_option("--truth", o.truth,
                 "TUM trajectory in the map's frame to measure by; without it the log's own truth")
      ->check(CLI::ExistingFile);
  app.add_flag("--beam", o.beam, "the beam model instead of the likelihood field");
  app.add_option("--beams", o.localisation.beams, "beams of a scan that are looked at")
      ->check(CLI::Range(4, 10000))
      ->capture_default_str();
  app.add_option("--max-range", o.localisation.max_range_m, "farther returns are left out, m")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  app.add_option("--particles", o.localisation.max_particles, "at most so many")
      ->check(CLI::Range(100, 10000000))
      ->capture_default_str();
  app.add_option("--sigma", o.map_options.sigma_m, "of a range about the wall it measures, m")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  examples::add_seed(app, o, "the same seed gives the same results");
  examples::add_threads(app, o);
  examples::add_manners(app, o);
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app(
      "Find a robot on a known map from its log of scans and odometry, by Monte-Carlo "
      "localisation.\nWrites trajectory.tum (the poses believed), poses.csv (every scan) and "
      "report.html.");
  Options o;
  add_options(app, o);
  CLI11_PARSE(app, argc, argv);
  if (o.beam) o.localisation.model = ScanLikelihood::beam;
  o.localisation.threads = o.threads;
  return examples::exit_code("localise", run(o));
}
