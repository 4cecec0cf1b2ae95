// Dead reckoning by gyro and wheels, aided by corridor walls, on a log or in simulation.

#include <cstdio>
#include <string>
#include <vector>

#include <wayfare/io/carmen.hpp>

#include "job.hpp"
#include "outputs.hpp"

namespace {

using namespace wayfare;
using namespace wayfare::examples;
using Options = CorridorArguments;

std::optional<LocalPlane> plane_of(const Options& o) {
  if (o.origin.size() != 3) return {};
  return LocalPlane{{Angle::degrees(o.origin[0]), Angle::degrees(o.origin[1]), 0.0},
                    Angle::degrees(o.origin[2])};
}

Result<void> run(const Options& o) {
  if (o.log.empty() == (o.simulated == 0))
    return Error{ErrorCode::invalid, "either a LOG or --simulated is needed", {}};
  std::vector<std::string> files = corridor_files();
  if (o.simulated > 0) files.emplace_back("log.carmen");
  if (auto ready = o.prepare(files); !ready) return ready;
  const auto job = make_job(o);
  if (!job) return job.error();
  const auto runs = run_all(*job, o);
  if (!runs) return runs.error();
  CorridorOutputs outputs{"Corridors: " + (o.log.empty() ? "simulated" : o.log),
                          job->recording,
                          runs->aided,
                          runs->unaided,
                          job->reference,
                          job->drive.has_value(),
                          plane_of(o)};
  outputs.facts = facts_of(*job, *runs, o);
  if (job->drive) {
    outputs.tables.emplace_back("Position RMSE by sections", section_table(*job, *runs));
    for (const CorridorEpoch& e : runs->aided.epochs)
      outputs.bias.push_back(true_bias_at(*job->drive, e.time) +
                             Angle::degrees(o.added_bias_deg_s).radians());
  } else if (!job->reference.empty()) {
    outputs.tables.emplace_back("Against the reference, both aligned",
                                reference_table(*job, *runs));
  }
  if (auto done = write_corridor_outputs(o, outputs); !done) return done;
  if (job->drive)
    if (auto done = io::write_carmen(o.path("log.carmen"), job->recording, o.write()); !done)
      return done;
  if (!o.quiet)
    std::printf("%s%s\nreport: %s\n", to_text(outputs.facts, 18).c_str(),
                to_text(outputs.tables).c_str(), o.path("report.html").c_str());
  return {};
}

void add_options(CommandLine& app, Options& o) {
  app.add_option(
         "LOG", o.log,
         std::string(kRobotLogs) + "; from CARMEN text, GYRO and WHEELS lines, else odometry")
      .existing_file();
  app.add_option("--simulated", o.simulated,
                 "instead of a log: three corridors with straight (1) or curved (2) motion")
      .range(1, 2);
  add_out(app, o);
  app.add_option("--reference", o.reference, "reference trajectory, TUM").existing_file();
  app.add_option("--add-bias", o.added_bias_deg_s, "bias added to the yaw rate, deg/s");
  app.add_option(
         "--origin", o.origin,
         "latitude, longitude and azimuth of the start's x axis, degrees: adds the solution "
         "in latitude and longitude, and removes the Earth's rotation")
      .expected(3);
  app.add_option("--config", o.config, "JSON file of options; see --print-config").existing_file();
  app.add_option("--passes", o.passes, "passes over a log, each started with the bias of the last")
      .range(1, 20)
      .show_default();
  app.add_flag("--no-walls-across", o.no_walls_across, "use side walls only");
  app.add_flag("--rest", o.rest, "estimate the bias from odometry at rest too");
  add_seed(app, o, "of the simulation");
  add_robot_topics(app, o.topics);
  add_force_and_quiet(app, o);
  app.add_print(
      "--print-config", [] { return corridor_options_text(); },
      "print all options of --config with their defaults for logs, and exit");
}

}  // namespace

int main(int argc, char** argv) {
  CommandLine app(
      "Dead reckoning by one gyro and wheels, aided by corridor walls in laser scans.\nWrites "
      "navigation.txt, trajectory.tum, unaided.tum, walls.png and report.html.");
  Options options;
  add_options(app, options);
  if (const auto code = app.parse(argc, argv)) return *code;
  return exit_code("corridor_ins", run(options));
}
