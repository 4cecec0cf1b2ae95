// Dead reckoning by gyro and wheels, held by the walls of corridors, on a log or in simulation.

#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

#include <wayfare/io/carmen.hpp>

#include "job.hpp"
#include "outputs.hpp"
#include "support/command_line.hpp"
#include "support/exit_code.hpp"
#include "support/program_files.hpp"

namespace {

using namespace wayfare;
using Options = examples::CorridorArguments;

std::optional<LocalPlane> plane_of(const Options& o) {
  if (o.origin.size() != 3) return {};
  return LocalPlane{{Angle::degrees(o.origin[0]), Angle::degrees(o.origin[1]), 0.0},
                    Angle::degrees(o.origin[2])};
}

Result<void> run(const Options& o) {
  if (o.log.empty() == (o.simulated == 0))
    return Error{ErrorCode::invalid, "either a LOG or --simulated is needed", {}};
  std::vector<std::string> files = examples::corridor_files();
  if (o.simulated > 0) files.emplace_back("log.carmen");
  if (auto ready = examples::prepare_files(o.out, files, o.write()); !ready) return ready;
  const auto job = examples::make_job(o);
  if (!job) return job.error();
  const auto runs = examples::run_all(*job, o);
  if (!runs) return runs.error();
  examples::CorridorOutputs outputs{"Corridors: " + (o.log.empty() ? "simulated" : o.log),
                                    job->recording,
                                    runs->aided,
                                    runs->unaided,
                                    job->reference,
                                    job->drive.has_value(),
                                    plane_of(o)};
  outputs.facts = examples::facts_of(*job, *runs, o);
  if (job->drive) {
    outputs.tables.emplace_back("Position RMSE by sections", examples::section_table(*job, *runs));
    for (const CorridorEpoch& e : runs->aided.epochs)
      outputs.bias.push_back(examples::true_bias_at(*job->drive, e.time) +
                             Angle::degrees(o.added_bias_deg_s).radians());
  } else if (!job->reference.empty()) {
    outputs.tables.emplace_back("Against the reference, both aligned",
                                examples::reference_table(*job, *runs));
  }
  const auto report = examples::write_corridor_outputs(o.out, outputs, o.write());
  if (!report) return report.error();
  if (job->drive) {
    const std::string log = (std::filesystem::path(o.out) / "log.carmen").string();
    if (auto done = io::write_carmen(log, job->recording, o.write()); !done) return done;
  }
  if (o.quiet) return {};
  for (const auto& [name, value] : outputs.facts)
    std::printf("%-18s %s\n", name.c_str(), value.c_str());
  for (const auto& [title, table] : outputs.tables)
    std::printf("\n%s\n%s", title.c_str(), table.to_text().c_str());
  std::printf("\nreport: %s\n", report->c_str());
  return {};
}

void add_options(examples::CommandLine& app, Options& o) {
  app.add_option("LOG", o.log,
                 std::string(examples::kRobotLogs) +
                     "; GYRO and WHEELS lines of CARMEN text, else odometry")
      .existing_file();
  app.add_option("--simulated", o.simulated,
                 "instead of a log: three corridors driven straight (1) or in curves (2)")
      .range(1, 2);
  examples::add_out(app, o, "folder for the results, made where needed");
  app.add_option("--reference", o.reference, "where the robot was, as a TUM trajectory")
      .existing_file();
  app.add_option("--add-bias", o.added_bias_deg_s, "added to the turn rate, to be found, deg/s");
  app.add_option("--origin", o.origin,
                 "latitude, longitude and azimuth of the start's x axis, degrees: the solution in "
                 "latitude and longitude too, and the Earth's turn taken out")
      .expected(3);
  app.add_option("--config", o.config, "JSON file of options; see --print-config").existing_file();
  app.add_option("--passes", o.passes, "times a log is gone through, each from the bias found last")
      .range(1, 20)
      .show_default();
  app.add_flag("--no-walls-across", o.no_walls_across, "use side walls alone");
  app.add_flag("--rest", o.rest, "take the bias from odometry at rest too");
  examples::add_seed(app, o, "of the simulation");
  examples::add_robot_topics(app, o.topics);
  examples::add_manners(app, o);
  app.add_print(
      "--print-config", [] { return examples::corridor_options_text(); },
      "print every option of --config with its default for logs, and end");
}

}  // namespace

int main(int argc, char** argv) {
  examples::CommandLine app(
      "Dead reckoning by one gyro and wheels, held by corridor walls in laser scans.\nWrites "
      "navigation.txt, trajectory.tum, unaided.tum, walls.png and report.html.");
  Options options;
  add_options(app, options);
  if (const auto code = app.parse(argc, argv)) return *code;
  return examples::exit_code("corridor_ins", run(options));
}
