// SLAM of simulated robots, with errors against the truth.

#include <cstdio>
#include <string>

#include <wayfare/io/carmen.hpp>
#include <wayfare/sim/floor_plan.hpp>
#include <wayfare/sim/simulate_recording.hpp>

#include "demos.hpp"
#include "support/progress_line.hpp"

namespace wayfare::examples {
namespace {

constexpr const char* kLogName = "robot.log";

// Wheels with a scale difference of one thousandth, and slip.
sim::RobotParams used_robot() {
  sim::RobotParams robot;
  robot.wheels.right_scale = 1.001;
  robot.wheels.slip_m_per_sqrt_m = 0.004;
  robot.T_base_laser = Transform2<frame::Base, frame::Laser>(SE2d(0.15, 0.0, Angle{}));
  return robot;
}

Result<sim::SimulatedRun> simulate(const SlamArguments& o) {
  const auto planned = sim::read_plan(sim::demo_building(), "the built-in building");
  if (!planned) return planned.error();
  ProgressLine progress("simulating a robot in a building", o.quiet);
  auto run = sim::simulate_recording(planned->plan, planned->route_m, used_robot(), Rng(o.seed),
                                     {std::ref(progress), {}});
  if (run) progress.finish();
  return run;
}

SlamOutputs outputs_of(const sim::SimulatedRun& simulated, const Timed<GraphSlamRun>& run,
                       std::uint64_t seed) {
  const double length_s = to_seconds(simulated.truth.back().time - simulated.truth.front().time);
  return {"A robot in a simulated building",
          simulated.recording,
          run.slam.trajectory,
          run.slam.map,
          run.slam.graph,
          &simulated.truth,
          {{"seed", std::to_string(seed)},
           {"scans", std::to_string(simulated.recording.scans.size())},
           {"driven", eval::fixed(eval::path_length_m(simulated.truth), 1) + " m in " +
                          eval::fixed(length_s, 0) + " s"},
           {"SLAM took", speed(run.took_s, length_s, 1)},
           {"graph", size_of(run.slam.graph)},
           {"loop closures", std::to_string(run.slam.statistics.loop_closures)}}};
}

/// A robot with LiDAR in an office floor, two rounds: graph SLAM.
Result<void> run_office(const SlamArguments& o) {
  if (auto ready = prepare_folder(o.out, o.write(), {kLogName}); !ready) return ready;
  const auto simulated = simulate(o);
  if (!simulated) return simulated.error();
  const auto slam = run_with_progress(simulated->recording, {}, o);
  if (!slam) return slam.error();
  const SlamOutputs outputs = outputs_of(*simulated, *slam, o.seed);
  const auto report = write_slam_outputs(o.out, outputs, o.write());
  if (!report) return report.error();
  if (auto done = io::write_carmen(o.path(kLogName), simulated->recording, o.write()); !done)
    return done;
  if (!o.quiet)
    std::printf("%s\n%s\nreport: %s\n", to_text(outputs.facts).c_str(),
                error_table(trajectory_errors(outputs)).to_text().c_str(), report->c_str());
  return {};
}

}  // namespace
}  // namespace wayfare::examples

int main(int argc, char** argv) {
  using namespace wayfare;
  using namespace wayfare::examples;
  CommandLine app(
      "Simulate a robot with radar and LiDAR in a loop of corridors, run graph SLAM and particle "
      "filters on its log and report their errors; or a robot with LiDAR in an office floor, and "
      "graph SLAM.");
  SlamArguments arguments;
  std::string world = "corridor_loop";
  add_out(app, arguments, "folder for log, trajectories, maps and report");
  app.add_option("--world", world, "corridor_loop or office")
      .one_of({"corridor_loop", "office"})
      .show_default();
  add_seed(app, arguments, "the same seed gives the same results");
  add_threads(app, arguments.threads);
  add_force_and_quiet(app, arguments);
  if (const auto code = app.parse(argc, argv)) return *code;
  return exit_code("demo", world == "office" ? run_office(arguments) : run_corridors(arguments));
}
