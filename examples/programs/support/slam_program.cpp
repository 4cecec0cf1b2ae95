#include "slam_program.hpp"

#include <cstdio>
#include <functional>
#include <utility>

#include <wayfare/io/carmen.hpp>
#include <wayfare/io/tum.hpp>
#include <wayfare/logger/messages.hpp>

#include "progress_line.hpp"

namespace wayfare::examples {

void add_threads(CommandLine& app, int& threads) {
  app.add_option("--threads", threads, "worker threads; results do not depend on their number")
      .range(1, 256)
      .show_default();
}

void add_seed(CommandLine& app, SlamArguments& arguments, const std::string& text) {
  app.add_option("--seed", arguments.seed, text).show_default();
}

Result<Recording> read_robot_log(const std::string& path, const ros::TopicNames& topics) {
  const auto recording_of = [](auto read) -> Result<Recording> {
    if (!read) return read.error();
    print_problems(read->problems);
    return std::move(read->recording);
  };
  if (ros::RecordingFile::is_one(path)) {
    const auto file = ros::RecordingFile::open(path);
    return file ? recording_of(ros::read_robot(*file, topics)) : file.error();
  }
  if (logger::is_recording(path)) return recording_of(logger::read_robot_recording(path));
  return recording_of(io::read_carmen(path));
}

Result<std::vector<eval::Relation>> read_relations_or_none(const std::string& path) {
  if (path.empty()) return std::vector<eval::Relation>();
  auto file = io::read_relations(path);
  if (!file) return file.error();
  print_problems(file->problems);
  return std::move(file->relations);
}

Result<Timed<GraphSlamRun>> run_with_progress(const Recording& recording, GraphSlamOptions options,
                                              const SlamArguments& arguments) {
  options.threads = arguments.threads;
  ProgressLine progress("graph SLAM", arguments.quiet);
  auto slam = run_graph_slam(recording, std::move(options), std::ref(progress));
  if (!slam) return slam.error();
  return Timed<GraphSlamRun>{*std::move(slam), progress.finish()};
}

std::string speed(double took_s, double recording_s, int decimals) {
  return eval::fixed(took_s, decimals) + " s, " + eval::fixed(recording_s / took_s, 0) +
         " times real time";
}

std::string size_of(const PoseGraph2& graph) {
  return std::to_string(graph.poses.size()) + " nodes, " + std::to_string(graph.edges.size()) +
         " edges";
}

std::string accepted_and_refused(std::size_t accepted, std::size_t refused) {
  return std::to_string(accepted) + " accepted, " + std::to_string(refused) + " refused";
}

void print_refused_scans(std::size_t count, const std::string& first) {
  if (count > 0) std::fprintf(stderr, "%zu scans refused, the first: %s\n", count, first.c_str());
}

void print_report(const SlamOutputs& outputs, const std::string& report) {
  std::printf("%s%s\nreport: %s\n", to_text(outputs.facts).c_str(), to_text(outputs.tables).c_str(),
              report.c_str());
}

}  // namespace wayfare::examples
