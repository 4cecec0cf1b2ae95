// LiDAR graph SLAM on a recorded log: a corrected trajectory, a map and a report out.

#include <chrono>
#include <cstdint>
#include <cstdio>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>

#include <wayfare/eval/relations.hpp>
#include <wayfare/eval/table.hpp>
#include <wayfare/io/carmen.hpp>
#include <wayfare/io/relations.hpp>
#include <wayfare/system/graph_slam.hpp>

#include "config.hpp"
#include "progress_line.hpp"
#include "slam_outputs.hpp"

namespace {

using namespace wayfare;

struct Options {
  std::string log, out, relations, config;
  int threads = 1;
  std::uint64_t seed = 1;
  bool no_odometry = false;
  bool force = false;
  bool quiet = false;
};

void print_problems(const io::Problems& problems) {
  constexpr std::size_t kShown = 5;
  for (std::size_t i = 0; i < problems.first().size() && i < kShown; ++i) {
    std::fprintf(stderr, "skipped: %s\n", problems.first()[i].to_string().c_str());
  }
  if (problems.count() > kShown) {
    std::fprintf(stderr, "skipped: %zu lines in all\n", problems.count());
  }
}

Trajectory odometry_trajectory(const Recording& recording) {
  Trajectory result;
  for (const auto& o : recording.odometry) {
    result.push_back({o.time, Transform2<frame::Map, frame::Base>(o.T_odom_base.raw())});
  }
  return result;
}

eval::Table relations_table(const Recording& recording, const Trajectory& trajectory,
                            const std::vector<eval::Relation>& relations) {
  eval::Table table({{"relations"}, {"used"}, {"translation", "m"}, {"rotation", "deg"}});
  const auto row = [&](const std::string& name, const Trajectory& estimated) {
    const auto e = eval::relations_error(estimated, relations);
    table.add_row({name, std::to_string(e.used) + " of " + std::to_string(relations.size()),
                   eval::mean_std(e.translation_m.mean, e.translation_m.std, 4),
                   eval::mean_std(e.rotation_deg.mean, e.rotation_deg.std, 3)});
  };
  if (!recording.odometry.empty()) row("odometry", odometry_trajectory(recording));
  row("graph SLAM", trajectory);
  return table;
}

Result<void> run(const Options& o) {
  GraphSlamOptions options;
  if (!o.config.empty()) {
    const auto config = examples::read_config(o.config);
    if (!config) return config.error();
    options = *config;
  }
  options.threads = o.threads;
  std::vector<eval::Relation> relations;
  if (!o.relations.empty()) {
    auto file = io::read_relations(o.relations);
    if (!file) return file.error();
    print_problems(file->problems);
    relations = std::move(file->relations);
  }
  auto log = io::read_carmen(o.log);
  if (!log) return log.error();
  print_problems(log->problems);
  Recording& recording = log->recording;
  if (o.no_odometry) recording.odometry.clear();

  examples::ProgressLine progress("graph SLAM", o.quiet);
  const auto start = std::chrono::steady_clock::now();
  const auto slam = run_graph_slam(recording, options, [&](double fraction) {
    progress.update(fraction);
    return true;
  });
  if (!slam) return slam.error();
  progress.finish();
  const double took_s =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  if (slam->refused_scans > 0) {
    std::fprintf(stderr, "%zu scans refused, the first: %s\n", slam->refused_scans,
                 slam->first_refusal.c_str());
  }

  const double lasts_s = to_seconds(recording.scans.back().time - recording.scans.front().time);
  examples::SlamOutputs outputs{
      "Graph SLAM of " + o.log,
      recording,
      slam->trajectory,
      slam->map,
      slam->graph,
      nullptr,
      {{"scans", std::to_string(slam->statistics.scans)},
       {"not matched", std::to_string(slam->statistics.unmatched_scans)},
       {"recording", eval::fixed(lasts_s, 1) + " s"},
       {"took",
        eval::fixed(took_s, 2) + " s, " + eval::fixed(lasts_s / took_s, 0) + " times real time"},
       {"graph", std::to_string(slam->graph.poses.size()) + " nodes, " +
                     std::to_string(slam->graph.edges.size()) + " edges"},
       {"loop closures", std::to_string(slam->statistics.loop_closures) + " accepted, " +
                             std::to_string(slam->statistics.loops_refused) + " refused"}}};
  if (!relations.empty()) {
    outputs.tables.push_back(
        {"Error over relations", relations_table(recording, slam->trajectory, relations)});
  }
  const auto report = examples::write_slam_outputs(
      o.out, outputs, {o.force ? io::Existing::replace : io::Existing::refuse});
  if (!report) return report.error();
  if (o.quiet) return {};
  for (const auto& [name, value] : outputs.facts) {
    std::printf("%-14s %s\n", name.c_str(), value.c_str());
  }
  for (const auto& titled : outputs.tables) std::printf("\n%s", titled.table.to_text().c_str());
  std::printf("\nreport: %s\n", report->c_str());
  return {};
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app(
      "Correct the trajectory of a recorded robot log by LiDAR graph SLAM and draw the map.\n"
      "LOG is a CARMEN text log, plain or gzip. Writes trajectory.tum, map.pgm, map.yaml, map.png, "
      "graph.g2o and report.html.");
  Options options;
  app.add_option("LOG", options.log, "the recorded log")->required()->check(CLI::ExistingFile);
  app.add_option("--out", options.out, "folder for the results, made where needed")->required();
  app.add_option("--relations", options.relations, "true relative poses to measure the result by")
      ->check(CLI::ExistingFile);
  app.add_option("--config", options.config, "JSON file of options; see --print-config")
      ->check(CLI::ExistingFile);
  app.add_option("--threads", options.threads, "worker threads; the results do not depend on them")
      ->check(CLI::Range(1, 256))
      ->capture_default_str();
  app.add_option("--seed", options.seed,
                 "accepted for uniformity: graph SLAM draws no random numbers")
      ->capture_default_str();
  app.add_flag("--no-odometry", options.no_odometry, "use the scans alone");
  app.add_flag("--force", options.force, "replace files of an earlier run");
  app.add_flag("--quiet", options.quiet, "no progress and no tables");
  app.add_flag_callback(
      "--print-config",
      [] {
        std::fputs(examples::default_config().c_str(), stdout);
        throw CLI::Success();
      },
      "print every option of --config with its default, and end");
  CLI11_PARSE(app, argc, argv);
  if (const auto done = run(options); !done) {
    std::fprintf(stderr, "graph_slam: %s\n", done.error().to_string().c_str());
    return 1;
  }
  return 0;
}
