// A robot drives two rounds through a simulated building; graph SLAM puts its log in order.

#include <chrono>
#include <cstdio>
#include <filesystem>
#include <string>

#include <CLI/CLI.hpp>

#include <wayfare/io/carmen_writer.hpp>
#include <wayfare/sim/plan_text.hpp>
#include <wayfare/sim/simulate_recording.hpp>
#include <wayfare/system/graph_slam.hpp>

#include "progress_line.hpp"
#include "slam_outputs.hpp"

namespace {

using namespace wayfare;

struct Options {
  std::string out;
  std::uint64_t seed = 1;
  int threads = 1;
  bool force = false;
  bool quiet = false;
};

// Wheels as a used robot has them: one a thousandth larger than the other, and slipping.
sim::RobotParams used_robot() {
  sim::RobotParams robot;
  robot.wheels.right_scale = 1.001;
  robot.wheels.slip_m_per_sqrt_m = 0.004;
  robot.T_base_laser = Transform2<frame::Base, frame::Laser>(SE2d(0.15, 0.0, Angle{}));
  return robot;
}

Result<sim::SimulatedRun> simulate(const Options& o) {
  const auto planned = sim::read_plan(sim::demo_building(), "the built-in building");
  if (!planned) return planned.error();
  examples::ProgressLine progress("simulating a robot in a building", o.quiet);
  auto run = sim::simulate_recording(planned->plan, planned->route_m, used_robot(), Rng(o.seed),
                                     {[&](double fraction) { progress.update(fraction); }, {}});
  if (run) progress.finish();
  return run;
}

Result<GraphSlamRun> localise_and_map(const Recording& recording, const Options& o) {
  GraphSlamOptions options;
  options.threads = o.threads;
  examples::ProgressLine progress("graph SLAM", o.quiet);
  auto run = run_graph_slam(recording, options, [&](double fraction) {
    progress.update(fraction);
    return true;
  });
  if (run) progress.finish();
  return run;
}

std::string number(double value, int decimals) { return eval::fixed(value, decimals); }

Result<void> run(const Options& o) {
  const auto simulated = simulate(o);
  if (!simulated) return simulated.error();
  const auto start = std::chrono::steady_clock::now();
  const auto slam = localise_and_map(simulated->recording, o);
  if (!slam) return slam.error();
  const double took_s =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  const double length_s = to_seconds(simulated->truth.back().time - simulated->truth.front().time);

  const examples::SlamOutputs outputs{
      "A robot in a simulated building",
      simulated->recording,
      slam->trajectory,
      slam->map,
      slam->graph,
      &simulated->truth,
      {{"seed", std::to_string(o.seed)},
       {"scans", std::to_string(simulated->recording.scans.size())},
       {"driven",
        number(eval::path_length_m(simulated->truth), 1) + " m in " + number(length_s, 0) + " s"},
       {"SLAM took",
        number(took_s, 1) + " s, " + number(length_s / took_s, 0) + " times real time"},
       {"graph", std::to_string(slam->graph.poses.size()) + " nodes, " +
                     std::to_string(slam->graph.edges.size()) + " edges"},
       {"loop closures", std::to_string(slam->statistics.loop_closures)}}};
  const io::WriteOptions write{o.force ? io::Existing::replace : io::Existing::refuse};
  const auto report = examples::write_slam_outputs(o.out, outputs, write);
  if (!report) return report.error();
  const std::string log = (std::filesystem::path(o.out) / "robot.log").string();
  if (auto done = io::write_carmen(log, simulated->recording, write); !done) return done;
  if (o.quiet) return {};
  for (const auto& [name, value] : outputs.facts)
    std::printf("%-14s %s\n", name.c_str(), value.c_str());
  std::printf("\n%s\n",
              examples::error_table(examples::trajectory_errors(outputs)).to_text().c_str());
  std::printf("report: %s\n", report->c_str());
  return {};
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app(
      "Simulate a robot's log in a building with long corridors, run graph SLAM on it and report "
      "how far odometry and SLAM are from the truth.");
  Options options;
  app.add_option("--out", options.out, "folder for log, trajectory, map, graph and report")
      ->required();
  app.add_option("--seed", options.seed, "the same seed gives the same results")
      ->capture_default_str();
  app.add_option("--threads", options.threads, "worker threads; the results do not depend on them")
      ->check(CLI::Range(1, 256))
      ->capture_default_str();
  app.add_flag("--force", options.force, "replace files of an earlier run");
  app.add_flag("--quiet", options.quiet, "no progress and no tables");
  CLI11_PARSE(app, argc, argv);
  if (const auto done = run(options); !done) {
    std::fprintf(stderr, "demo: %s\n", done.error().to_string().c_str());
    return 1;
  }
  return 0;
}
