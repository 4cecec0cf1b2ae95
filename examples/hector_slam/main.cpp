// Hector-class SLAM on a recorded log: every scan matched to one map at several resolutions.

#include <chrono>
#include <cstdio>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include <wayfare/eval/table.hpp>
#include <wayfare/system/hector_slam.hpp>

#include "exit_code.hpp"
#include "option_fields.hpp"
#include "progress_line.hpp"
#include "relations_table.hpp"
#include "slam_program.hpp"

namespace {

using namespace wayfare;

struct Options : examples::SlamArguments {
  std::string log, relations, config;
  bool no_odometry = false;
};

std::vector<examples::OptionField> fields(HectorSlamOptions& o) {
  using examples::option_field;
  return {option_field("cell_m", o.map.finest.resolution_m),
          option_field("levels", o.map.levels),
          option_field("p_free", o.map.model.p_free),
          option_field("p_hit", o.map.model.p_hit),
          option_field("unknown_probability", o.map.unknown_probability),
          option_field("max_iterations", o.match.max_iterations),
          option_field("start_step_deg", o.match.start_step),
          option_field("max_range_m", o.max_range_m),
          option_field("point_spacing_m", o.point_spacing_m),
          option_field("map_travel_m", o.map_travel_m),
          option_field("map_turn_deg", o.map_turn),
          option_field("search_sigmas", o.search_sigmas),
          option_field("independent_points", o.independent_points),
          option_field("least_score", o.least_score)};
}

Result<HectorSlamOptions> read_options(const Options& o) {
  HectorSlamOptions options;
  if (o.config.empty()) return options;
  if (auto ok = examples::read_option_fields(o.config, fields(options)); !ok) return ok.error();
  if (options.map.levels > 8 || options.map.model.p_free >= 1 || options.map.model.p_hit >= 1 ||
      options.map.unknown_probability > 1)
    return Error{ErrorCode::parse, "levels are at most 8, probabilities below 1", o.config};
  return options;
}

struct Timed {
  HectorRun slam;
  double took_s = 0.0;
};

Result<Timed> run_timed(const Recording& recording, const HectorSlamOptions& options, bool quiet) {
  examples::ProgressLine progress("Hector SLAM", quiet);
  const auto start = std::chrono::steady_clock::now();
  auto slam = run_hector_slam(recording, options, [&](double fraction) {
    progress.update(fraction);
    return true;
  });
  if (!slam) return slam.error();
  progress.finish();
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start;
  if (slam->refused_scans > 0)
    std::fprintf(stderr, "%zu scans refused, the first: %s\n", slam->refused_scans,
                 slam->first_refusal.c_str());
  return Timed{*std::move(slam), took.count()};
}

std::vector<std::pair<std::string, std::string>> facts(const Recording& recording,
                                                       const Timed& run) {
  const double lasts_s = to_seconds(recording.scans.back().time - recording.scans.front().time);
  const HectorStatistics& s = run.slam.statistics;
  return {{"scans", std::to_string(s.scans)},
          {"not matched", std::to_string(s.unmatched_scans)},
          {"in the map", std::to_string(s.scans_in_map)},
          {"recording", eval::fixed(lasts_s, 1) + " s"},
          {"took", examples::speed(run.took_s, lasts_s, 2)},
          {"a scan", eval::fixed(1e6 * run.took_s / static_cast<double>(s.scans), 0) + " us"}};
}

Result<void> run(const Options& o) {
  const auto options = read_options(o);
  if (!options) return options.error();
  const auto relations = examples::read_relations_or_none(o.relations);
  if (!relations) return relations.error();
  auto recording = examples::read_robot_log(o.log);
  if (!recording) return recording.error();
  if (o.no_odometry) recording->odometry.clear();
  if (auto ready = examples::prepare_folder(o.out, o.write()); !ready) return ready;
  const auto run = run_timed(*recording, *options, o.quiet);
  if (!run) return run.error();
  const PoseGraph2 none;
  examples::SlamOutputs outputs{
      "Hector SLAM of " + o.log, *recording, run->slam.trajectory, run->slam.map, none, nullptr,
      facts(*recording, *run)};
  if (!relations->empty())
    outputs.tables.push_back(
        {"Error over relations",
         examples::relations_table("Hector SLAM", *recording, run->slam.trajectory, *relations)});
  const auto report = examples::write_slam_outputs(o.out, outputs, o.write());
  if (!report) return report.error();
  if (o.quiet) return {};
  examples::print_facts(outputs);
  for (const auto& titled : outputs.tables) std::printf("\n%s", titled.table.to_text().c_str());
  std::printf("\nreport: %s\n", report->c_str());
  return {};
}

void add_options(CLI::App& app, Options& o) {
  app.add_option("LOG", o.log, "the recorded log")->required()->check(CLI::ExistingFile);
  examples::add_out(app, o, "folder for the results, made where needed");
  app.add_option("--relations", o.relations, "true relative poses to measure the result by")
      ->check(CLI::ExistingFile);
  app.add_option("--config", o.config, "JSON file of options; see --print-config")
      ->check(CLI::ExistingFile);
  examples::add_threads(app, o);
  examples::add_seed(app, o, "accepted for uniformity: no random numbers are drawn");
  app.add_flag("--no-odometry", o.no_odometry, "use the scans alone");
  examples::add_manners(app, o);
  app.add_flag_callback(
      "--print-config",
      [] {
        HectorSlamOptions defaults;
        std::fputs(examples::option_fields_text(fields(defaults)).c_str(), stdout);
        throw CLI::Success();
      },
      "print every option of --config with its default, and end");
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app(
      "Follow a robot by matching each scan of a recorded log to one map at several resolutions; "
      "no loop closures.\nLOG is a CARMEN text log, plain or gzip, or a logger's recording "
      "(.mcap). "
      "Writes trajectory.tum, map.pgm, map.yaml, map.png and report.html.");
  Options options;
  add_options(app, options);
  CLI11_PARSE(app, argc, argv);
  return examples::exit_code("hector_slam", run(options));
}
