#include "slam_program.hpp"

#include <algorithm>
#include <cstdio>
#include <functional>
#include <utility>

#include <wayfare/io/carmen.hpp>
#include <wayfare/io/text_file.hpp>
#include <wayfare/io/tum.hpp>
#include <wayfare/logger/messages.hpp>
#include <wayfare/sim/simulate_recording.hpp>

#include "process_memory.hpp"
#include "slam_doubt.hpp"

namespace wayfare::examples {
namespace {

struct Arguments : SlamArguments {
  std::string relations, config;
  bool no_odometry = false, relations_by_scan = false;
};

void add_options(CommandLine& app, Arguments& o, const LogProgram& program) {
  app.add_file("LOG", o.log, "the recorded log").required();
  add_out(app, o);
  o.truth.add_options(app);
  app.add_file("--relations", o.relations, "true relative poses, to compare with");
  add_relations_by_scan(app, o.relations_by_scan);
  app.add_file("--config", o.config, "JSON file of options; see --print-config");
  add_threads(app, o.threads);
  add_seed(app, o, "of the random numbers: " + program.system + " uses none");
  app.add_flag("--no-odometry", o.no_odometry, "use the scans alone");
  add_robot_topics(app, o.topics);
  add_force_and_quiet(app, o);
  add_json(app, o);
  app.add_print(
      "--print-config", [&program] { return option_fields_text(program.options); },
      "print all options of --config with their defaults, and exit");
  app.example("robot.log --out result", "trajectory, map and report of a log");
  app.example("robot.bag --scan-topic /scan --json - --out result",
              "the same of a ROS recording, with the numbers of the report on standard output");
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

Result<Recording> read_recording(const Arguments& o, Doubt& doubt) {
  auto recording = read_robot_log(o.log, o.topics, true, &doubt);
  if (!recording) return recording;
  if (recording->scans.empty())
    return Error{ErrorCode::not_found, "contains no laser scans", o.log};
  if (o.no_odometry) recording->odometry.clear();
  drop_still_odometry(*recording);
  return recording;
}

Facts facts_of(const Recording& recording, const Timed<LogRun>& run) {
  const double recording_s = to_seconds(recording.scans.back().time - recording.scans.front().time);
  Facts facts = {{"scans", std::to_string(run.slam.scans)},
                 {"not matched", std::to_string(run.slam.unmatched_scans)}};
  facts.insert(facts.end(), run.slam.facts.begin(), run.slam.facts.end());
  const double scan_us = 1e6 * run.took_s / static_cast<double>(run.slam.scans);
  facts.insert(facts.end(), {{"recording", eval::fixed(recording_s, 1) + " s"},
                             {"took", speed(run.took_s, recording_s, 2)},
                             {"per scan", eval::fixed(scan_us, 0) + " us"},
                             {"peak memory", eval::fixed(peak_memory_mb(), 0) + " MB"}});
  return facts;
}

/// Scans are rarely refused or unmatched where a result is right.
void add_doubts(const Recording& recording, const LogRun& slam, Doubt& doubt) {
  constexpr double kShare = 0.1;
  doubt_share(doubt, slam.refused_scans, recording.scans.size(), "scans are refused", kShare);
  doubt_share(doubt, slam.unmatched_scans, slam.scans, "scans do not match the map", kShare);
  if (slam.doubt.empty())
    doubt_path_leaps(doubt, recording, slam.trajectory);
  else
    doubt.add(slam.doubt);
  doubt_odometry(doubt, recording, slam.trajectory);
}

Result<Doubt> run(const Arguments& o, const LogProgram& program) {
  if (auto ok = read_config(o.config, program); !ok) return ok.error();
  auto relations = read_relations_or_none(o.relations);
  if (!relations) return relations.error();
  if (auto ready = prepare_folder(o.out, o.write(), program.more_files); !ready)
    return ready.error();
  if (auto ready = o.prepare_json(); !ready) return ready.error();
  Doubt doubt;
  const auto recording = read_recording(o, doubt);
  if (!recording) return recording.error();
  if (o.relations_by_scan) relations = eval::relations_by_scan(*relations, recording->scans);
  if (!relations) return relations.error();
  const auto truth = o.read_truth(*recording);
  if (!truth) return truth.error();
  const auto run = run_timed(program.system, o.quiet, [&](ProgressLine& progress) {
    return program.run(*recording, o, std::ref(progress));
  });
  if (!run) return run.error();
  print_refused_scans(run->slam.refused_scans, run->slam.first_refusal);
  const LogRun& slam = run->slam;
  SlamOutputs outputs{
      program.system + " of " + o.log, *recording, slam.trajectory, slam.map, slam.graph, *truth,
      facts_of(*recording, *run)};
  outputs.others = slam.others;
  add_doubts(*recording, slam, doubt);
  outputs.doubt = doubt.why;
  if (!relations->empty())
    outputs.tables.emplace_back(
        "Error over relations",
        eval::relations_table(program.system, *recording, slam.trajectory, *relations));
  const auto report = write_slam_outputs(o.out, outputs, o.write(), o.json);
  if (!report) return report.error();
  if (!o.quiet) print_report(outputs, *report);
  return doubt;
}

}  // namespace

void StateFiles::add_options(CommandLine& app) {
  app.add_file("--continue", from,
               "a map saved by an earlier run with the same options, to continue; LOG is the log "
               "after it");
  app.add_option("--save", to, "file to save the map to, for --continue").shown_as("FILE");
  app.example("tuesday.log --continue monday.map --save both.map --out tuesday",
              "goes on from the map that --save wrote before");
}

Error StateFiles::named(Error error) const {
  if (error.source == "saved map") error.source = from;
  return error;
}

Result<std::vector<std::uint8_t>> StateFiles::read(const io::WriteOptions& options) const {
  if (auto ready = check_writable({to}, options); !ready) return ready.error();
  if (from.empty()) return std::vector<std::uint8_t>();
  const auto file = io::read_file(from, {std::size_t{1} << 40});
  if (!file) return file.error();
  if (file->bytes.empty()) return Error{ErrorCode::parse, "is empty", from};
  return std::vector<std::uint8_t>(file->bytes.begin(), file->bytes.end());
}

Result<void> StateFiles::write(const std::vector<std::uint8_t>& state,
                               const io::WriteOptions& options) const {
  if (to.empty()) return {};
  return io::write_file(to, {reinterpret_cast<const char*>(state.data()), state.size()}, options);
}

Result<Truth> SlamArguments::read_truth(const Recording& recording) const {
  return truth.read(log, recording.truth, times_of(recording), topics);
}

void add_threads(CommandLine& app, int& threads) {
  app.add_number("--threads", threads, 1, 256, kThreadsHelp);
}

void add_relations_by_scan(CommandLine& app, bool& by_scan) {
  app.add_flag("--relations-by-scan", by_scan,
               "the times of --relations are numbers of scans, from 0: for logs with other clocks")
      .needs("--relations");
}

void add_seed(CommandLine& app, SlamArguments& arguments, const std::string& text) {
  app.add_option("--seed", arguments.seed, text).show_default();
}

namespace {

/// What a user must know of a log's times and lines before its results.
void say_state(const std::string& path, const io::CarmenLog& log, Doubt* doubt) {
  const io::CarmenStatistics& count = log.statistics;
  if (!count.clock_reason.empty())
    std::fprintf(stderr, "warning: %s: %s\n", path.c_str(), count.clock_reason.c_str());
  if (count.skipped_lines * 100 <= count.lines) return;
  const std::string skipped =
      std::to_string(count.skipped_lines) + " of " + std::to_string(count.lines) +
      " lines of the log were skipped, most: " + log.problems.most_frequent();
  std::fprintf(stderr, "warning: %s: %s\n", path.c_str(), skipped.c_str());
  if (doubt != nullptr && count.skipped_lines * 2 > count.lines) doubt->add(skipped);
}

}  // namespace

Result<Recording> read_robot_log(const std::string& path, const ros::TopicNames& topics,
                                 bool needs_laser, Doubt* doubt) {
  const auto recording_of = [](auto read) -> Result<Recording> {
    if (!read) return read.error();
    print_problems(read->problems);
    Recording& r = read->recording;
    if (r.odometry.empty() && r.wheel_base_m > 0.0)
      r.odometry = sim::dead_reckon(r.wheels, r.wheel_base_m);
    return std::move(r);
  };
  if (ros::RecordingFile::is_one(path)) {
    const auto file = ros::RecordingFile::open(path);
    return file ? recording_of(ros::read_robot(*file, topics)) : file.error();
  }
  if (logger::is_recording(path)) return recording_of(logger::read_robot_recording(path));
  io::CarmenOptions options;
  options.needs_laser = needs_laser;
  auto log = io::read_carmen(path, options);
  if (log) say_state(path, *log, doubt);
  return recording_of(std::move(log));
}

void drop_still_odometry(Recording& recording) {
  std::vector<OdometrySample>& odometry = recording.odometry;
  const bool still = std::all_of(odometry.begin(), odometry.end(), [&](const OdometrySample& s) {
    return s.T_odom_base.raw().minus(odometry.front().T_odom_base.raw()).isZero(0);
  });
  if (still) odometry.clear();
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
  return run_timed("graph SLAM", arguments.quiet, [&](ProgressLine& progress) {
    return run_graph_slam(recording, std::move(options), std::ref(progress));
  });
}

std::size_t particles_of(SlamSensors sensors) { return sensors == SlamSensors::radar ? 10 : 30; }

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
  std::printf("%s%s\nreport: %s\n", to_text(outputs.facts).c_str(),
              to_text(tables_of(outputs)).c_str(), report.c_str());
}

int run_log_program(int argc, char** argv, const LogProgram& program) {
  CommandLine app(program.description + "\nLOG is " + kRobotLogs +
                  ". Writes trajectory.tum, map.pgm, map.yaml, map.png, report.html and, for a "
                  "system with a pose graph, graph.g2o.");
  Arguments arguments;
  add_options(app, arguments, program);
  if (const auto code = app.parse(argc, argv)) return *code;
  return exit_code(program.name.c_str(), run(arguments, program));
}

}  // namespace wayfare::examples
