// A robot drives two rounds through a simulated building; graph SLAM puts its log in order.

#include <cstdio>
#include <filesystem>
#include <string>

#include <wayfare/io/carmen.hpp>
#include <wayfare/sim/floor_plan.hpp>
#include <wayfare/sim/simulate_recording.hpp>

#include "demos.hpp"
#include "support/progress_line.hpp"

namespace wayfare::examples {
namespace {

constexpr const char* kLogName = "robot.log";

// Wheels as a used robot has them: one a thousandth larger than the other, and slipping.
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
                                     {[&](double fraction) { progress.update(fraction); }, {}});
  if (run) progress.finish();
  return run;
}

SlamOutputs outputs_of(const sim::SimulatedRun& simulated, const TimedRun& run,
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

void print(const SlamOutputs& outputs, const std::string& report) {
  print_facts(outputs);
  const eval::Table errors = error_table(trajectory_errors(outputs));
  std::printf("\n%s\nreport: %s\n", errors.to_text().c_str(), report.c_str());
}

}  // namespace

Result<void> run_office(const SlamArguments& o) {
  if (auto ready = prepare_folder(o.out, o.write(), {kLogName}); !ready) return ready;
  const auto simulated = simulate(o);
  if (!simulated) return simulated.error();
  const auto slam = run_with_progress(simulated->recording, {}, o);
  if (!slam) return slam.error();
  const SlamOutputs outputs = outputs_of(*simulated, *slam, o.seed);
  const auto report = write_slam_outputs(o.out, outputs, o.write());
  if (!report) return report.error();
  const std::string log = (std::filesystem::path(o.out) / kLogName).string();
  if (auto done = io::write_carmen(log, simulated->recording, o.write()); !done) return done;
  if (!o.quiet) print(outputs, *report);
  return {};
}

}  // namespace wayfare::examples
