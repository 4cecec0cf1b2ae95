// Graph SLAM on a simulated robot that drives for hours: time of a scan, memory and error over
// time; saved on the way and, if asked, killed.

#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <limits>
#include <string>
#include <vector>

#include <wayfare/eval/trajectory_error.hpp>
#include <wayfare/io/map_image.hpp>
#include <wayfare/io/report.hpp>
#include <wayfare/io/tum.hpp>
#include <wayfare/slam/graph_slam.hpp>

#include "edge_check.hpp"
#include "robot.hpp"
#include "support/process_memory.hpp"
#include "support/program_files.hpp"

namespace {

using namespace wayfare;
using namespace wayfare::examples;

struct Options : OutputArguments {
  double hours = 1.0, kilometres = 20.0, scan_period_s = 0.5;
  bool away = false, check_edges = false;
  GraphSlamOptions slam;
  std::uint64_t seed = 1;
  std::size_t save_every = 0, kill_at = 0;
};

/// Processor time: other programs do not change it.
double thread_s() {
  timespec now{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// Over a part of the run.
struct Part {
  std::vector<double> scan_ms;
  double squares = 0.0, worst_m = 0.0;

  void add(double ms, double error_m) {
    scan_ms.push_back(ms);
    squares += error_m * error_m;
    worst_m = std::max(worst_m, error_m);
  }
  [[nodiscard]] double mean_ms() const {
    double sum = 0.0;
    for (const double ms : scan_ms) sum += ms;
    return sum / static_cast<double>(scan_ms.size());
  }
  [[nodiscard]] double rms_m() const {
    return std::sqrt(squares / static_cast<double>(scan_ms.size()));
  }
};

struct Run {
  GraphSlam slam;
  Trajectory truth = {};
  io::Series ms{"mean", {}, {}}, worst_ms{"largest", {}, {}}, memory{"process", {}, {}},
      nodes{"nodes", {}, {}}, error{"position", {}, {}};
  Part part = {};
};

void report_part(Run& run, const EndlessRobot& robot) {
  const double hours = robot.time().seconds() / 3600.0;
  const auto largest = std::ranges::max(run.part.scan_ms);
  const auto nodes = static_cast<double>(run.slam.graph().poses.size());
  run.ms.add(hours, run.part.mean_ms());
  run.worst_ms.add(hours, largest);
  run.memory.add(hours, resident_memory_mb());
  run.nodes.add(hours, nodes);
  run.error.add(hours, run.part.rms_m());
  std::printf(
      "%.3f h, %.2f km: %.2f ms a scan, at most %.1f; %.0f nodes, %zu edges, %.1f MB; "
      "error %.3f m, at most %.3f\n",
      hours, robot.travelled_m() / 1000.0, run.part.mean_ms(), largest, nodes,
      run.slam.graph().edges.size(), resident_memory_mb(), run.part.rms_m(), run.part.worst_m);
  std::fflush(stdout);
  run.part = {};
}

Result<void> add_scan(Run& run, const EndlessRobot& robot) {
  const LaserScan scan = robot.scan();
  const double begin = thread_s();
  const auto outcome =
      run.slam.add_scan(scan, Transform2<frame::Odom, frame::Base>(robot.odometry()));
  const double took_s = thread_s() - begin;
  if (!outcome) return outcome.error();
  const SE2d apart = robot.truth().inverse() * outcome->T_map_base.raw();
  run.part.add(1e3 * took_s, apart.translation().norm());
  return {};
}

Result<void> save(const Options& o, const Run& run) {
  const std::vector<std::uint8_t> state = run.slam.save();
  return io::write_file(o.path("state"),
                        {reinterpret_cast<const char*>(state.data()), state.size()},
                        {io::Existing::replace});
}

/// The state saved by an earlier run, if there is one.
Result<GraphSlam> started(const Options& o, const GraphSlamOptions& options) {
  if (o.save_every == 0 || !std::filesystem::exists(o.path("state"))) return GraphSlam(options);
  const auto file = io::read_file(o.path("state"), {std::size_t{1} << 40});
  if (!file) return file.error();
  return GraphSlam::restore(
      {reinterpret_cast<const std::uint8_t*>(file->bytes.data()), file->bytes.size()}, options);
}

double all_poses_error_m(const Run& run, eval::Alignment alignment) {
  return eval::absolute_error(run.slam.trajectory(), run.truth, {alignment}).translation_m.rmse;
}

/// In the frame of the first pose, whose heading error turns all of the map, and without that.
void print_error(const Run& run, const char* when) {
  std::printf("error of all poses %s: %.3f m, %.3f m aligned; %zu nodes\n", when,
              all_poses_error_m(run, eval::Alignment::none),
              all_poses_error_m(run, eval::Alignment::rigid), run.slam.graph().poses.size());
}

/// Normalised squared errors of the edges with the true poses.
void print_edges(const Run& run) {
  constexpr double kLarge = 25.0;
  const Trajectory estimate = run.slam.trajectory();
  for (const bool robust : {false, true}) {
    const EdgeErrors e = edge_errors(run.slam.graph(), robust, estimate, run.truth);
    std::printf("%zu %s edges: chi2 with the true poses %.3f, median %.3f, %zu above %.0f\n",
                e.chi2.size(), robust ? "loop" : "other", e.mean(), e.median(), e.above(kLarge),
                kLarge);
  }
}

Result<void> write(const Options& o, Run& run) {
  const GraphSlamStatistics& s = run.slam.statistics();
  const double slam_mb = resident_memory_mb();
  const OccupancyGrid map = run.slam.map();
  io::Report report("Graph SLAM over hours",
                    o.away ? "a corridor that does not return" : "a building of 100 m x 100 m");
  report.facts(
      {{"scans", std::to_string(s.scans)},
       {"not matched", std::to_string(s.unmatched_scans)},
       {"nodes", std::to_string(run.slam.graph().poses.size())},
       {"loop closures", std::to_string(s.loop_closures)},
       {"memory before the map is drawn", eval::fixed(slam_mb, 0) + " MB"},
       {"peak memory", eval::fixed(peak_memory_mb(), 0) + " MB"},
       {"error, aligned", eval::fixed(all_poses_error_m(run, eval::Alignment::rigid), 3) + " m"}});
  const auto plot = [&](const char* title, const char* unit, std::vector<io::Series> series) {
    report.plot({title, "simulated time [h]", unit, std::move(series)});
  };
  plot("Time of a scan", "[ms]", {run.ms, run.worst_ms});
  plot("Memory", "[MB]", {run.memory});
  plot("Nodes", "number", {run.nodes});
  plot("Error of the latest pose", "[m]", {run.error});
  io::MapImageOptions map_options;
  map_options.file = o.write();
  return first_error({io::write_tum(o.path("trajectory.tum"), run.slam.trajectory(), o.write()),
                      io::write_map(o.path("map"), map, map_options),
                      io::write_png(o.path("map.png"), io::picture_rows(map), o.write()),
                      o.write_report(report)});
}

Result<void> drive(const Options& o, const sim::FloorPlan& plan) {
  auto slam = started(o, o.slam);
  if (!slam) return slam.error();
  const std::size_t done = slam->statistics().scans;
  Run run{*std::move(slam)};
  EndlessRobot robot(plan, !o.away, o.scan_period_s, Rng(o.seed).stream(7));
  const auto scans_a_part = static_cast<std::size_t>(600.0 / o.scan_period_s);
  const double end_s = o.away ? std::numeric_limits<double>::infinity() : 3600.0 * o.hours;
  for (std::size_t i = 1; robot.time().seconds() < end_s; ++i, robot.advance()) {
    if (o.away && robot.travelled_m() > 1000.0 * o.kilometres) break;
    run.truth.push_back({robot.time(), Transform2<frame::Map, frame::Base>(robot.truth())});
    if (i <= done) continue;
    if (auto ok = add_scan(run, robot); !ok) return ok;
    if (run.part.scan_ms.size() == scans_a_part) report_part(run, robot);
    if (o.save_every > 0 && i % o.save_every == 0)
      if (auto ok = save(o, run); !ok) return ok;
    if (i == o.kill_at) std::raise(SIGKILL);
  }
  if (!run.part.scan_ms.empty()) report_part(run, robot);
  print_error(run, "before the last optimisation");
  if (o.check_edges) print_edges(run);
  if (auto ok = run.slam.finish(); !ok) return ok;
  print_error(run, "at the end");
  return write(o, run);
}

Result<void> run(const Options& o) {
  if (auto ready = o.prepare({"trajectory.tum", "map.pgm", "map.yaml", "map.png", "report.html"});
      !ready)
    return ready;
  const auto plan = o.away ? corridor_plan(1000.0 * o.kilometres + 40.0, Rng(o.seed))
                           : building_plan(Rng(o.seed));
  return plan ? drive(o, *plan) : plan.error();
}

}  // namespace

int main(int argc, char** argv) {
  CommandLine app(
      "Graph SLAM on a simulated robot that drives for hours through a building of 100 m x 100 m, "
      "or away along a corridor: time of a scan, memory and error every ten minutes.");
  Options o;
  add_out(app, o);
  app.add_number("--hours", o.hours, 0.01, 1000.0, "simulated time in the building");
  app.add_flag("--away", o.away, "a corridor that does not return, instead of the building");
  app.add_number("--kilometres", o.kilometres, 0.1, 100.0, "length of the corridor");
  app.add_flag("--check-edges", o.check_edges,
               "prints how the edges' information fits their errors with the true poses");
  app.add_number("--scan-period", o.scan_period_s, 0.1, 10.0, "time between scans, s");
  app.add_number("--merge-from", o.slam.nodes_before_merging, 0, 1 << 28,
                 "nodes_before_merging of graph SLAM; 0: never");
  app.add_positive("--merge-distance", o.slam.merge_distance_m, "merge_distance_m of graph SLAM");
  app.add_option("--seed", o.seed, kSeedHelp).show_default();
  app.add_option("--save-every", o.save_every,
                 "scans between saves to the file 'state', from which a run continues; 0: never");
  app.add_option("--kill-at", o.kill_at, "scan after which the program kills itself; 0: none");
  add_force_and_quiet(app, o);
  add_json(app, o);
  app.example("--hours 2 --merge-from 1 --out out/merged",
              "two hours with nodes of known area merged");
  if (const auto code = app.parse(argc, argv)) return *code;
  return exit_code("endless_runs", run(o));
}
