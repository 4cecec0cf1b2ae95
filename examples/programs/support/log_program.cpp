#include "log_program.hpp"

#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <cstdio>

#include <wayfare/eval/table.hpp>

#include "command_line.hpp"
#include "exit_code.hpp"
#include "progress_line.hpp"
#include "relations_table.hpp"

namespace wayfare::examples {
namespace {

struct Arguments : SlamArguments {
  std::string relations, config;
  bool no_odometry = false;
};

void add_options(CommandLine& app, Arguments& o, const LogProgram& program) {
  app.add_option("LOG", o.log, "the recorded log").required().existing_file();
  add_out(app, o, "folder for the results, made where needed");
  app.add_option("--relations", o.relations, "true relative poses to measure the result by")
      .existing_file();
  app.add_option("--config", o.config, "JSON file of options; see --print-config").existing_file();
  add_threads(app, o);
  add_seed(app, o, "accepted for uniformity: " + program.system + " draws no random numbers");
  app.add_flag("--no-odometry", o.no_odometry, "use the scans alone");
  add_robot_topics(app, o.topics);
  add_manners(app, o);
  app.add_print(
      "--print-config", [&program] { return option_fields_text(program.options); },
      "print every option of --config with its default, and end");
  if (program.more_options) program.more_options(app);
}

Result<void> read_config(const std::string& path, const LogProgram& program) {
  if (!path.empty()) {
    if (auto ok = read_option_fields(path, program.options); !ok) return ok;
  }
  if (!program.check_options) return {};
  auto ok = program.check_options();
  if (ok) return {};
  Error error = ok.error();
  error.source = path;
  return error;
}

/// Logs of carriers without wheels hold one pose, over and over.
bool never_moves(const std::vector<OdometrySample>& odometry) {
  return std::all_of(odometry.begin(), odometry.end(), [&](const OdometrySample& s) {
    return s.T_odom_base.raw().minus(odometry.front().T_odom_base.raw()).isZero(0);
  });
}

Result<Recording> read_recording(const Arguments& o) {
  auto recording = read_robot_log(o.log, o.topics);
  if (recording && (o.no_odometry || never_moves(recording->odometry))) recording->odometry.clear();
  return recording;
}

struct Timed {
  LogRun slam;
  double took_s = 0.0;
};

Result<Timed> run_timed(const Recording& recording, const LogProgram& program, const Arguments& o) {
  ProgressLine progress(program.system, o.quiet);
  const auto start = std::chrono::steady_clock::now();
  auto slam = program.run(recording, o, [&](double fraction) {
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

/// The most memory the program has held so far, the log it read included.
std::string peak_memory() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return eval::fixed(static_cast<double>(usage.ru_maxrss) / 1024.0, 0) + " MB";
}

std::vector<std::pair<std::string, std::string>> facts(const Recording& recording,
                                                       const Timed& run) {
  const double lasts_s = to_seconds(recording.scans.back().time - recording.scans.front().time);
  std::vector<std::pair<std::string, std::string>> facts = {
      {"scans", std::to_string(run.slam.scans)},
      {"not matched", std::to_string(run.slam.unmatched_scans)}};
  facts.insert(facts.end(), run.slam.facts.begin(), run.slam.facts.end());
  const double scan_us = 1e6 * run.took_s / static_cast<double>(run.slam.scans);
  facts.insert(facts.end(), {{"recording", eval::fixed(lasts_s, 1) + " s"},
                             {"took", speed(run.took_s, lasts_s, 2)},
                             {"a scan", eval::fixed(scan_us, 0) + " us"},
                             {"peak memory", peak_memory()}});
  return facts;
}

Result<void> run(const Arguments& o, const LogProgram& program) {
  if (auto ok = read_config(o.config, program); !ok) return ok;
  const auto relations = read_relations_or_none(o.relations);
  if (!relations) return relations.error();
  const auto recording = read_recording(o);
  if (!recording) return recording.error();
  if (auto ready = prepare_folder(o.out, o.write()); !ready) return ready;
  const auto run = run_timed(*recording, program, o);
  if (!run) return run.error();
  const LogRun& slam = run->slam;
  SlamOutputs outputs{
      program.system + " of " + o.log, *recording, slam.trajectory, slam.map, slam.graph, nullptr,
      facts(*recording, *run)};
  if (!relations->empty())
    outputs.tables.push_back(
        {"Error over relations",
         relations_table(program.system, *recording, slam.trajectory, *relations)});
  const auto report = write_slam_outputs(o.out, outputs, o.write());
  if (!report) return report.error();
  if (!o.quiet) print_report(outputs, *report);
  return {};
}

}  // namespace

int run_log_program(int argc, char** argv, const LogProgram& program) {
  CommandLine app(
      program.description + "\nLOG is " + kRobotLogs +
      ". Writes "
      "trajectory.tum, map.pgm, map.yaml, map.png, report.html and, where the system keeps "
      "a graph, graph.g2o.");
  Arguments arguments;
  add_options(app, arguments, program);
  if (const auto code = app.parse(argc, argv)) return *code;
  return exit_code(program.name.c_str(), run(arguments, program));
}

}  // namespace wayfare::examples
