// LiDAR graph SLAM on a recorded log: a corrected trajectory, a map and a report out.

#include <cstdio>
#include <string>

#include <CLI/CLI.hpp>

#include <wayfare/eval/table.hpp>

#include "config.hpp"
#include "exit_code.hpp"
#include "relations_table.hpp"
#include "slam_program.hpp"

namespace {

using namespace wayfare;

struct Options : examples::SlamArguments {
  std::string log, relations, config;
  bool no_odometry = false;
};

void print_refused(const GraphSlamRun& slam) {
  if (slam.refused_scans == 0) return;
  std::fprintf(stderr, "%zu scans refused, the first: %s\n", slam.refused_scans,
               slam.first_refusal.c_str());
}

Result<GraphSlamOptions> read_options(const Options& o) {
  return o.config.empty() ? GraphSlamOptions() : examples::read_config(o.config);
}

Result<Recording> read_recording(const Options& o) {
  auto recording = examples::read_robot_log(o.log);
  if (recording && o.no_odometry) recording->odometry.clear();
  return recording;
}

examples::SlamOutputs outputs_of(const std::string& log, const Recording& recording,
                                 const examples::TimedRun& run) {
  const double lasts_s = to_seconds(recording.scans.back().time - recording.scans.front().time);
  const GraphSlamStatistics& statistics = run.slam.statistics;
  return {"Graph SLAM of " + log,
          recording,
          run.slam.trajectory,
          run.slam.map,
          run.slam.graph,
          nullptr,
          {{"scans", std::to_string(statistics.scans)},
           {"not matched", std::to_string(statistics.unmatched_scans)},
           {"recording", eval::fixed(lasts_s, 1) + " s"},
           {"took", examples::speed(run.took_s, lasts_s, 2)},
           {"graph", examples::size_of(run.slam.graph)},
           {"loop closures", std::to_string(statistics.loop_closures) + " accepted, " +
                                 std::to_string(statistics.loops_refused) + " refused"}}};
}

void print(const examples::SlamOutputs& outputs, const std::string& report) {
  examples::print_facts(outputs);
  for (const auto& titled : outputs.tables) std::printf("\n%s", titled.table.to_text().c_str());
  std::printf("\nreport: %s\n", report.c_str());
}

Result<void> run(const Options& o) {
  const auto options = read_options(o);
  if (!options) return options.error();
  const auto relations = examples::read_relations_or_none(o.relations);
  if (!relations) return relations.error();
  const auto recording = read_recording(o);
  if (!recording) return recording.error();
  if (auto ready = examples::prepare_folder(o.out, o.write()); !ready) return ready;
  const auto run = examples::run_with_progress(*recording, *options, o);
  if (!run) return run.error();
  print_refused(run->slam);
  examples::SlamOutputs outputs = outputs_of(o.log, *recording, *run);
  if (!relations->empty()) {
    outputs.tables.push_back(
        {"Error over relations",
         examples::relations_table("graph SLAM", *recording, run->slam.trajectory, *relations)});
  }
  const auto report = examples::write_slam_outputs(o.out, outputs, o.write());
  if (!report) return report.error();
  if (!o.quiet) print(outputs, *report);
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
  examples::add_seed(app, o, "accepted for uniformity: graph SLAM draws no random numbers");
  app.add_flag("--no-odometry", o.no_odometry, "use the scans alone");
  examples::add_manners(app, o);
  app.add_flag_callback(
      "--print-config",
      [] {
        std::fputs(examples::default_config().c_str(), stdout);
        throw CLI::Success();
      },
      "print every option of --config with its default, and end");
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app(
      "Correct the trajectory of a recorded robot log by LiDAR graph SLAM and draw the map.\n"
      "LOG is a CARMEN text log, plain or gzip, or a logger's recording (.mcap). Writes "
      "trajectory.tum, map.pgm, map.yaml, map.png, "
      "graph.g2o and report.html.");
  Options options;
  add_options(app, options);
  CLI11_PARSE(app, argc, argv);
  return examples::exit_code("graph_slam", run(options));
}
