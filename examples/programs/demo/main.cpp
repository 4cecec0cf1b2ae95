// SLAM of simulated robots, with errors against the truth: four methods on one log of a loop of
// corridors, and graph SLAM in an office.

#include <algorithm>
#include <cstdio>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include <wayfare/eval/trajectory_error.hpp>
#include <wayfare/io/carmen.hpp>
#include <wayfare/io/report.hpp>
#include <wayfare/io/tum.hpp>
#include <wayfare/sensors/trajectory.hpp>
#include <wayfare/sim/floor_plan.hpp>
#include <wayfare/sim/simulate_recording.hpp>
#include <wayfare/sim/worlds.hpp>
#include <wayfare/slam/radar_slam.hpp>

#include "support/progress_line.hpp"
#include "support/slam_program.hpp"

namespace {

using namespace wayfare;
using namespace wayfare::examples;

struct Method {
  std::string file;  ///< names its trajectory and its map
  std::string name;
  Trajectory trajectory = {};
  OccupancyGrid map = OccupancyGrid{};
  double took_s = 0.0;
  eval::AbsoluteError errors = {};
  std::string remark = {};
};

std::vector<Method> methods() {
  return {{"odometry", "wheel odometry"},
          {"graph", "graph SLAM, LiDAR"},
          {"radar", "particle filter, radar"},
          {"both", "particle filter, radar and LiDAR"}};
}

std::vector<std::string> names_of(const std::vector<Method>& all) {
  std::vector<std::string> names{"robot.log", "truth.tum", "report.html"};
  for (const Method& m : all) {
    names.push_back(m.file + ".tum");
    if (m.file != "odometry") names.push_back(m.file + ".png");
  }
  return names;
}

Result<Recording> simulate(const SlamArguments& o) {
  ProgressLine progress("simulating a robot in corridors", o.quiet);
  const Rng rng(o.seed);
  const auto world = sim::make_world("corridor_loop", rng);
  if (!world) return world.error();
  auto recording = sim::simulate_world(*world, sim::turtlebot(rng), rng, {std::ref(progress), {}});
  if (recording) progress.finish();
  return recording;
}

Result<void> run_graph(const Recording& recording, const SlamArguments& o, Method& m) {
  auto run = run_with_progress(recording, {}, o);
  if (!run) return run.error();
  m.trajectory = std::move(run->slam.trajectory);
  m.map = std::move(run->slam.map);
  m.took_s = run->took_s;
  m.remark = std::to_string(run->slam.statistics.loop_closures) + " loop closures";
  return {};
}

Result<void> run_filter(const Recording& recording, const SlamArguments& o, SlamSensors sensors,
                        Method& m) {
  RadarSlamOptions options;
  options.particles = 10;
  options.seed = o.seed;
  options.threads = o.threads;
  auto run = run_timed(m.name, o.quiet, [&](ProgressLine& progress) {
    return run_radar_slam(recording, options, sensors, std::ref(progress));
  });
  if (!run) return run.error();
  m.took_s = run->took_s;
  m.trajectory = std::move(run->slam.trajectory);
  m.map = run->slam.map();
  m.remark = std::to_string(options.particles) + " particles, resampled " +
             std::to_string(run->slam.statistics.resampled) + " times";
  return {};
}

Result<void> run_all(const Recording& recording, const SlamArguments& o, std::vector<Method>& all) {
  all[0].trajectory = as_trajectory(recording.odometry);
  if (auto done = run_graph(recording, o, all[1]); !done) return done;
  if (auto done = run_filter(recording, o, SlamSensors::radar, all[2]); !done) return done;
  if (auto done = run_filter(recording, o, SlamSensors::both, all[3]); !done) return done;
  for (Method& m : all)
    m.errors =
        eval::absolute_error(m.trajectory, recording.truth, {eval::Alignment::start, {}, true});
  return {};
}

eval::Table table_of(const std::vector<Method>& all) {
  eval::Table table({{""},
                     {"RMSE x", "m"},
                     {"RMSE y", "m"},
                     {"heading", "deg"},
                     {"at the end", "m"},
                     {"largest", "m"},
                     {"took", "s"}});
  for (const Method& m : all)
    table.add_row({m.name, eval::fixed(m.errors.rmse_x_m, 3), eval::fixed(m.errors.rmse_y_m, 3),
                   eval::fixed(m.errors.rmse_heading_deg, 2), eval::fixed(m.errors.end_m, 3),
                   eval::fixed(m.errors.translation_m.max, 3), eval::fixed(m.took_s, 1)});
  return table;
}

/// So that every method has the same colour in all plots, with and without odometry.
std::vector<Method> odometry_last(std::vector<Method> all) {
  std::rotate(all.begin(), all.begin() + 1, all.end());
  return all;
}

/// All runs start at the first true pose.
io::Plot paths(const std::vector<Method>& all, const Trajectory& truth) {
  io::Plot plot = io::top_view("Paths, started at the same pose");
  for (const Method& m : odometry_last(all)) {
    const auto start = pose_at(truth, m.trajectory.front().time);
    const SE2d T = *start * m.trajectory.front().T_map_base.raw().inverse();
    plot.series.push_back(io::path_series(m.name, m.trajectory, T));
  }
  plot.series.push_back(io::path_series("truth", truth, {}, io::Mark::dashed));
  return plot;
}

io::Plot distances(const std::vector<Method>& all, bool with_odometry) {
  io::Plot plot = io::time_plot(
      with_odometry ? "Distance from the truth" : "The same without odometry", "error [m]");
  for (const Method& m : odometry_last(all)) {
    if (!with_odometry && m.file == "odometry") continue;
    io::Series series{m.name, {}, m.errors.translations_m};
    for (const LogTime time : m.errors.times)
      series.x.push_back(to_seconds(time - m.trajectory.front().time));
    plot.series.push_back(std::move(series));
  }
  return plot;
}

Facts facts_of(const Recording& recording, const SlamArguments& o) {
  const double recording_s = to_seconds(recording.truth.back().time - recording.truth.front().time);
  return {{"seed", std::to_string(o.seed)},
          {"driven", eval::fixed(eval::path_length_m(recording.truth), 1) + " m in " +
                         eval::fixed(recording_s, 0) + " s"},
          {"LiDAR scans", std::to_string(recording.scans.size())},
          {"radar frames", std::to_string(recording.radar.size())}};
}

io::Report report_of(const std::vector<Method>& all, const Recording& recording,
                     const SlamArguments& o) {
  io::Report report("A robot with radar and LiDAR in a simulated loop of corridors");
  report.facts(facts_of(recording, o));
  report.heading("Errors against the truth")
      .paragraph(
          "All started at the same pose, without further alignment. The LiDAR has a range of 3.5 "
          "m: it sees two walls, which determine the motion along them poorly. The radar detects "
          "door frames and reflectors in the walls, which do, but its bearings are coarse.")
      .table(table_of(all));
  report.plot(paths(all, recording.truth)).plot(distances(all, true)).plot(distances(all, false));
  report.heading("Maps");
  for (const Method& m : all)
    if (m.file != "odometry")
      report.image(map_picture(m.map, m.trajectory), m.name + ": " + m.remark + ".");
  return report;
}

Result<void> write(const std::vector<Method>& all, const Recording& recording,
                   const SlamArguments& o) {
  for (const Method& m : all) {
    if (auto done = io::write_tum(o.path(m.file + ".tum"), m.trajectory, o.write()); !done)
      return done;
    if (m.file == "odometry") continue;
    const io::Image picture = map_picture(m.map, m.trajectory);
    if (auto done = io::write_png(o.path(m.file + ".png"), picture, o.write()); !done) return done;
  }
  return first_error({io::write_tum(o.path("truth.tum"), recording.truth, o.write()),
                      io::write_carmen(o.path("robot.log"), recording, o.write()),
                      o.write_report(report_of(all, recording, o))});
}

/// A robot with radar and LiDAR in a loop of corridors: odometry, graph SLAM and particle filters.
Result<void> run_corridors(const SlamArguments& o) {
  std::vector<Method> all = methods();
  if (auto ready = o.prepare(names_of(all)); !ready) return ready;
  const auto recording = simulate(o);
  if (!recording) return recording.error();
  if (auto done = run_all(*recording, o, all); !done) return done;
  if (auto done = write(all, *recording, o); !done || o.quiet) return done;
  std::printf("%s\n%s\nreport: %s\n", to_text(facts_of(*recording, o)).c_str(),
              table_of(all).to_text().c_str(), o.path("report.html").c_str());
  return {};
}

constexpr const char* kLogName = "robot.log";

// Wheels with a scale difference of one thousandth, and slip.
sim::RobotParams used_robot() {
  sim::RobotParams robot;
  robot.wheels.right_scale = 1.001;
  robot.wheels.slip_m_per_sqrt_m = 0.004;
  robot.T_base_laser = Transform2<frame::Base, frame::Laser>(SE2d(0.15, 0.0, Angle{}));
  return robot;
}

Result<sim::SimulatedRun> simulate_office(const SlamArguments& o) {
  const auto planned = sim::read_plan(sim::demo_building(), "the built-in building");
  if (!planned) return planned.error();
  ProgressLine progress("simulating a robot in a building", o.quiet);
  auto run = sim::simulate_recording(planned->plan, planned->route_m, used_robot(), Rng(o.seed),
                                     {std::ref(progress), {}});
  if (run) progress.finish();
  return run;
}

SlamOutputs outputs_of(const sim::SimulatedRun& simulated, const Truth& truth,
                       const Timed<GraphSlamRun>& run, std::uint64_t seed) {
  const double length_s = to_seconds(simulated.truth.back().time - simulated.truth.front().time);
  return {"A robot in a simulated building",
          simulated.recording,
          run.slam.trajectory,
          run.slam.map,
          run.slam.graph,
          truth,
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
  if (auto ready = o.prepare_json(); !ready) return ready;
  const auto simulated = simulate_office(o);
  if (!simulated) return simulated.error();
  const auto slam = run_with_progress(simulated->recording, {}, o);
  if (!slam) return slam.error();
  const Truth truth(simulated->truth, "the simulation");
  const SlamOutputs outputs = outputs_of(*simulated, truth, *slam, o.seed);
  const auto report = write_slam_outputs(o.out, outputs, o.write(), o.json);
  if (!report) return report.error();
  if (auto done = io::write_carmen(o.path(kLogName), simulated->recording, o.write()); !done)
    return done;
  if (!o.quiet) print_report(outputs, *report);
  return {};
}

}  // namespace

int main(int argc, char** argv) {
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
  add_seed(app, arguments, kSeedHelp);
  add_threads(app, arguments.threads);
  add_force_and_quiet(app, arguments);
  add_json(app, arguments);
  app.example("--out demo", "robot with radar and LiDAR in corridors");
  app.example("--out office --world office --threads 2", "LiDAR in an office floor");
  if (const auto code = app.parse(argc, argv)) return *code;
  return exit_code("demo", world == "office" ? run_office(arguments) : run_corridors(arguments));
}
