#include "slam_program.hpp"

#include <chrono>
#include <cstdio>
#include <utility>

#include <wayfare/io/carmen.hpp>
#include <wayfare/logger/read_recording.hpp>

#include "command_line.hpp"
#include "program_files.hpp"
#include "progress_line.hpp"

namespace wayfare::examples {

void add_out(CommandLine& app, SlamArguments& arguments, const std::string& text) {
  app.add_option("--out", arguments.out, text).required();
}

void add_threads(CommandLine& app, SlamArguments& arguments) {
  app.add_option("--threads", arguments.threads,
                 "worker threads; the results do not depend on them")
      .range(1, 256)
      .show_default();
}

void add_seed(CommandLine& app, SlamArguments& arguments, const std::string& text) {
  app.add_option("--seed", arguments.seed, text).show_default();
}

void add_manners(CommandLine& app, SlamArguments& arguments) {
  app.add_flag("--force", arguments.force, "replace files of an earlier run");
  app.add_flag("--quiet", arguments.quiet, "no progress and no tables");
}

Result<Recording> read_robot_log(const std::string& path, const ros::TopicNames& topics) {
  if (ros::RecordingFile::is_one(path)) {
    const auto file = ros::RecordingFile::open(path);
    if (!file) return file.error();
    auto run = ros::read_robot(*file, topics);
    if (!run) return run.error();
    print_problems(run->problems);
    return std::move(run->recording);
  }
  if (logger::is_recording(path)) {
    auto logged = logger::read_robot_recording(path);
    if (!logged) return logged.error();
    print_problems(logged->problems);
    return std::move(logged->recording);
  }
  auto log = io::read_carmen(path);
  if (!log) return log.error();
  print_problems(log->problems);
  return std::move(log->recording);
}

Result<TimedRun> run_with_progress(const Recording& recording, GraphSlamOptions options,
                                   const SlamArguments& arguments) {
  options.threads = arguments.threads;
  ProgressLine progress("graph SLAM", arguments.quiet);
  const auto start = std::chrono::steady_clock::now();
  auto slam = run_graph_slam(recording, std::move(options), [&](double fraction) {
    progress.update(fraction);
    return true;
  });
  if (!slam) return slam.error();
  progress.finish();
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start;
  return TimedRun{*std::move(slam), took.count()};
}

std::string speed(double took_s, double lasts_s, int decimals) {
  return eval::fixed(took_s, decimals) + " s, " + eval::fixed(lasts_s / took_s, 0) +
         " times real time";
}

std::string size_of(const PoseGraph2& graph) {
  return std::to_string(graph.poses.size()) + " nodes, " + std::to_string(graph.edges.size()) +
         " edges";
}

void print_facts(const SlamOutputs& outputs) {
  for (const auto& [name, value] : outputs.facts)
    std::printf("%-14s %s\n", name.c_str(), value.c_str());
}

void print_report(const SlamOutputs& outputs, const std::string& report) {
  print_facts(outputs);
  for (const auto& titled : outputs.tables) std::printf("\n%s", titled.table.to_text().c_str());
  std::printf("\nreport: %s\n", report.c_str());
}

}  // namespace wayfare::examples
