// Submap SLAM on a recorded log: local submaps, loop closure by branch and bound, pose adjustment.

#include <chrono>
#include <cstdint>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include <wayfare/eval/table.hpp>
#include <wayfare/system/submap_slam.hpp>

#include "config.hpp"
#include "exit_code.hpp"
#include "progress_line.hpp"
#include "relations_table.hpp"
#include "slam_program.hpp"

namespace {

using namespace wayfare;

constexpr const char* kState = "submaps.bin";

struct Options : examples::SlamArguments {
  std::string log, relations, config, saved;
  bool no_odometry = false;
};

Result<SubmapSlamOptions> read_options(const Options& o) {
  SubmapSlamOptions options;
  options.threads = o.threads;
  if (o.config.empty()) return options;
  if (auto ok = examples::read_option_fields(o.config, examples::submap_slam_fields(options)); !ok)
    return ok.error();
  const auto probability = [](double p) { return p > 0 && p < 1; };
  if (options.grid.levels > 8 || !probability(options.grid.model.p_free) ||
      !probability(options.grid.model.p_hit) || options.grid.unknown_probability > 1)
    return Error{ErrorCode::parse, "levels are at most 8, probabilities below 1", o.config};
  return options;
}

Result<std::vector<std::uint8_t>> read_saved(const std::string& path) {
  if (path.empty()) return std::vector<std::uint8_t>();
  std::ifstream file(path, std::ios::binary);
  std::vector<std::uint8_t> bytes{std::istreambuf_iterator<char>(file), {}};
  if (!file || bytes.empty()) return Error{ErrorCode::io, "cannot be read, or is empty", path};
  return bytes;
}

Result<void> write_saved(const std::string& path, const std::vector<std::uint8_t>& bytes) {
  std::ofstream file(path, std::ios::binary);
  file.write(reinterpret_cast<const char*>(bytes.data()), std::ssize(bytes));
  file.close();
  if (!file) return Error{ErrorCode::io, "cannot be written", path};
  return {};
}

struct Timed {
  SubmapSlamRun slam;
  double took_s = 0.0;
};

Result<Timed> run_timed(const Recording& recording, const SubmapSlamOptions& options,
                        const std::vector<std::uint8_t>& saved, bool quiet) {
  examples::ProgressLine progress("submap SLAM", quiet);
  const auto start = std::chrono::steady_clock::now();
  auto slam = run_submap_slam(
      recording, options,
      [&](double fraction) {
        progress.update(fraction);
        return true;
      },
      saved);
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
  const SubmapSlamStatistics& s = run.slam.statistics;
  return {
      {"scans", std::to_string(s.scans)},
      {"not matched", std::to_string(s.unmatched_scans)},
      {"recording", eval::fixed(lasts_s, 1) + " s"},
      {"took", examples::speed(run.took_s, lasts_s, 2)},
      {"a scan", eval::fixed(1e6 * run.took_s / static_cast<double>(s.scans), 0) + " us"},
      {"submaps", std::to_string(s.submaps) + " of " + std::to_string(s.nodes) + " scans"},
      {"graph", examples::size_of(run.slam.graph)},
      {"loop closures", std::to_string(s.loop_closures) + " accepted, " +
                            std::to_string(s.loops_refused) + " refused"},
      {"memory", eval::fixed(static_cast<double>(run.slam.memory_bytes) / (1 << 20), 1) + " MiB"}};
}

Result<void> run(const Options& o) {
  const auto options = read_options(o);
  if (!options) return options.error();
  const auto relations = examples::read_relations_or_none(o.relations);
  if (!relations) return relations.error();
  auto recording = examples::read_robot_log(o.log);
  if (!recording) return recording.error();
  if (o.no_odometry) recording->odometry.clear();
  const auto saved = read_saved(o.saved);
  if (!saved) return saved.error();
  if (auto ready = examples::prepare_folder(o.out, o.write(), {kState}); !ready) return ready;
  const auto run = run_timed(*recording, *options, *saved, o.quiet);
  if (!run) return run.error();
  examples::SlamOutputs outputs{
      "Submap SLAM of " + o.log, *recording, run->slam.trajectory,   run->slam.map,
      run->slam.graph,           nullptr,    facts(*recording, *run)};
  if (!relations->empty())
    outputs.tables.push_back(
        {"Error over relations",
         examples::relations_table("submap SLAM", *recording, run->slam.trajectory, *relations)});
  const auto report = examples::write_slam_outputs(o.out, outputs, o.write());
  if (!report) return report.error();
  if (auto ok = write_saved(o.out + "/" + kState, run->slam.state); !ok) return ok;
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
  app.add_option("--continue", o.saved,
                 "submaps.bin of an earlier run with the same options, to go on from; LOG is what "
                 "came after it")
      ->check(CLI::ExistingFile);
  examples::add_threads(app, o);
  examples::add_seed(app, o, "accepted for uniformity: no random numbers are drawn");
  app.add_flag("--no-odometry", o.no_odometry, "use the scans alone");
  examples::add_manners(app, o);
  app.add_flag_callback(
      "--print-config",
      [] {
        SubmapSlamOptions defaults;
        std::fputs(examples::option_fields_text(examples::submap_slam_fields(defaults)).c_str(),
                   stdout);
        throw CLI::Success();
      },
      "print every option of --config with its default, and end");
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app(
      "Correct the trajectory of a recorded robot log by submaps and loop closure and draw the "
      "map.\nLOG is a CARMEN text log, plain or gzip, or a logger's recording (.mcap). Writes "
      "trajectory.tum, map.pgm, map.yaml, map.png, graph.g2o, report.html and submaps.bin, from "
      "which --continue goes on.");
  Options options;
  add_options(app, options);
  CLI11_PARSE(app, argc, argv);
  return examples::exit_code("submap_slam", run(options));
}
