// A robot drives two rounds through a simulated building; graph SLAM puts its log in order.

#include <cstdio>
#include <filesystem>
#include <string>

#include <CLI/CLI.hpp>

#include <wayfare/io/carmen_writer.hpp>
#include <wayfare/sim/plan_text.hpp>
#include <wayfare/sim/simulate_recording.hpp>

#include "exit_code.hpp"
#include "progress_line.hpp"
#include "slam_program.hpp"

namespace {

using namespace wayfare;

constexpr const char* kLogName = "robot.log";

// Wheels as a used robot has them: one a thousandth larger than the other, and slipping.
sim::RobotParams used_robot() {
  sim::RobotParams robot;
  robot.wheels.right_scale = 1.001;
  robot.wheels.slip_m_per_sqrt_m = 0.004;
  robot.T_base_laser = Transform2<frame::Base, frame::Laser>(SE2d(0.15, 0.0, Angle{}));
  return robot;
}

Result<sim::SimulatedRun> simulate(const examples::SlamArguments& o) {
  const auto planned = sim::read_plan(sim::demo_building(), "the built-in building");
  if (!planned) return planned.error();
  examples::ProgressLine progress("simulating a robot in a building", o.quiet);
  auto run = sim::simulate_recording(planned->plan, planned->route_m, used_robot(), Rng(o.seed),
                                     {[&](double fraction) { progress.update(fraction); }, {}});
  if (run) progress.finish();
  return run;
}

examples::SlamOutputs outputs_of(const sim::SimulatedRun& simulated, const examples::TimedRun& run,
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
           {"SLAM took", examples::speed(run.took_s, length_s, 1)},
           {"graph", examples::size_of(run.slam.graph)},
           {"loop closures", std::to_string(run.slam.statistics.loop_closures)}}};
}

void print(const examples::SlamOutputs& outputs, const std::string& report) {
  examples::print_facts(outputs);
  const eval::Table errors = examples::error_table(examples::trajectory_errors(outputs));
  std::printf("\n%s\nreport: %s\n", errors.to_text().c_str(), report.c_str());
}

Result<void> run(const examples::SlamArguments& o) {
  if (auto ready = examples::prepare_folder(o.out, o.write(), {kLogName}); !ready) return ready;
  const auto simulated = simulate(o);
  if (!simulated) return simulated.error();
  const auto slam = examples::run_with_progress(simulated->recording, {}, o);
  if (!slam) return slam.error();
  const examples::SlamOutputs outputs = outputs_of(*simulated, *slam, o.seed);
  const auto report = examples::write_slam_outputs(o.out, outputs, o.write());
  if (!report) return report.error();
  const std::string log = (std::filesystem::path(o.out) / kLogName).string();
  if (auto done = io::write_carmen(log, simulated->recording, o.write()); !done) return done;
  if (!o.quiet) print(outputs, *report);
  return {};
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app(
      "Simulate a robot's log in a building with long corridors, run graph SLAM on it and report "
      "how far odometry and SLAM are from the truth.");
  examples::SlamArguments arguments;
  examples::add_out(app, arguments, "folder for log, trajectory, map, graph and report");
  examples::add_seed(app, arguments, "the same seed gives the same results");
  examples::add_threads(app, arguments);
  examples::add_manners(app, arguments);
  CLI11_PARSE(app, argc, argv);
  return examples::exit_code("demo", run(arguments));
}
