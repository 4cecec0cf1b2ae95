// Dead reckoning by gyro and wheels, aided by corridor walls, on a log or in simulation.

#include <array>
#include <cstdio>
#include <string>
#include <utility>
#include <vector>

#include <wayfare/eval/trajectory_error.hpp>
#include <wayfare/io/carmen.hpp>
#include <wayfare/sensors/trajectory.hpp>

#include "job.hpp"
#include "outputs.hpp"

namespace {

using namespace wayfare;
using namespace wayfare::examples;
using Options = CorridorArguments;

/// Mean yaw rate of the motion minus that of the reference, rad/s.
double reference_bias(std::span<const MotionSample> motion, const Trajectory& reference) {
  double measured = 0.0, rotated = 0.0, seconds = 0.0;
  for (std::size_t i = 1; i < motion.size(); ++i) {
    const auto a = pose_at(reference, motion[i - 1].time);
    const auto b = pose_at(reference, motion[i].time);
    if (!a || !b) continue;
    const double dt = to_seconds(motion[i].time - motion[i - 1].time);
    measured += motion[i].turn_rate_rad_s * dt;
    rotated += (a->inverse() * *b).heading().radians();
    seconds += dt;
  }
  return (measured - rotated) / seconds;
}

std::string rate(double rad_s) {
  return eval::fixed(Angle::radians(rad_s).degrees(), 4) + " deg/s";
}

void add_bias_facts(const Job& job, const Runs& runs, const Options& o, Facts& facts) {
  const CorridorEpoch& last = runs.aided.epochs.back();
  facts.emplace_back("gyro bias", rate(last.gyro_bias.value) + " +- " + rate(last.gyro_bias.sigma));
  if (job.drive)
    facts.emplace_back("true bias", rate(true_bias_at(*job.drive, last.time) +
                                         Angle::degrees(o.added_bias_deg_s).radians()));
  const auto motion = motion_of(job.recording, Angle::degrees(o.added_bias_deg_s).radians());
  if (!job.drive && !job.reference.empty())
    facts.emplace_back("by reference", rate(reference_bias(motion, job.reference)));
  if (!runs.without_added) return;
  const double plain = runs.without_added->epochs.back().gyro_bias.value;
  const double found = Angle::radians(last.gyro_bias.value - plain).degrees();
  facts.emplace_back("without the added", rate(plain));
  facts.emplace_back("added bias found", eval::fixed(100.0 * found / o.added_bias_deg_s, 2) +
                                             " % of " + eval::fixed(o.added_bias_deg_s, 3) +
                                             " deg/s");
}

void add_report_facts(const CorridorReport& r, Facts& facts) {
  const auto share = [&](std::size_t n) {
    return std::to_string(n) + " (" +
           eval::fixed(100.0 * static_cast<double>(n) / static_cast<double>(r.scans), 1) + " %)";
  };
  facts.emplace_back("scans", std::to_string(r.scans));
  facts.emplace_back("with walls", share(r.scans_with_walls));
  facts.emplace_back("walls used", share(r.scans_used));
  facts.emplace_back("by tracking", share(r.tracked));
  facts.emplace_back("end walls", share(r.end_walls_used));
  facts.emplace_back("corridors", std::to_string(r.corridors));
  facts.emplace_back("longest outage", eval::fixed(to_seconds(r.longest_outage), 1) + " s");
  facts.emplace_back("refused", std::to_string(r.refused_walls) + " scans, " +
                                    std::to_string(r.refused_sides) + " sides, " +
                                    std::to_string(r.refused_end_walls) + " end walls, " +
                                    std::to_string(r.not_parallel) + " not parallel, " +
                                    std::to_string(r.slipping_samples) + " slipping, " +
                                    std::to_string(r.saturated_samples) + " saturated");
}

Facts facts_of(const Job& job, const Runs& runs, const Options& o) {
  Facts facts;
  add_bias_facts(job, runs, o, facts);
  add_report_facts(runs.aided.report, facts);
  return facts;
}

std::array<std::pair<const char*, const CorridorRun*>, 2> named(const Runs& runs) {
  return {{{"with walls", &runs.aided}, {"without", &runs.unaided}}};
}

/// Errors by section of the simulated drive.
eval::Table section_table(const Job& job, const Runs& runs) {
  std::vector<eval::Table::Column> columns{{""}};
  for (int s = 0; s < 5; ++s)
    columns.push_back({std::string(sim::name_of(static_cast<sim::CorridorSection>(s))), "m"});
  columns.push_back({"Total", "m"});
  eval::Table table(columns);
  for (const auto& [name, run] : named(runs)) {
    std::vector<std::string> row{name};
    for (const double e : errors_of(*run, *job.drive, job.rest_s).position_rmse_m)
      row.push_back(eval::fixed(e, 3));
    table.add_row(std::move(row));
  }
  return table;
}

/// Errors against the reference after a rigid alignment.
eval::Table reference_table(const Job& job, const Runs& runs) {
  eval::Table table({{""}, {"RMSE", "m"}, {"heading", "deg"}, {"largest", "m"}});
  for (const auto& [name, run] : named(runs)) {
    const auto e = eval::absolute_error(trajectory_of(*run), job.reference);
    table.add_row({name, eval::fixed(e.translation_m.rmse, 3), eval::fixed(e.rmse_heading_deg, 2),
                   eval::fixed(e.translation_m.max, 3)});
  }
  return table;
}

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
  app.add_file(
      "LOG", o.log,
      std::string(kRobotLogs) + "; from CARMEN text, GYRO and WHEELS lines, else odometry");
  app.add_option("--simulated", o.simulated,
                 "instead of a log: three corridors with straight (1) or curved (2) motion")
      .range(1, 2);
  add_out(app, o);
  app.add_file("--reference", o.reference, "reference trajectory, TUM");
  app.add_option("--add-bias", o.added_bias_deg_s, "bias added to the yaw rate, deg/s");
  app.add_option(
         "--origin", o.origin,
         "latitude, longitude and azimuth of the start's x axis, degrees: adds the solution "
         "in latitude and longitude, and removes the Earth's rotation")
      .expected(3);
  app.add_file("--config", o.config, "JSON file of options; see --print-config");
  app.add_number("--passes", o.passes, 1, 20,
                 "passes over a log, each started with the bias of the last");
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
