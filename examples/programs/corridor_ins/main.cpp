// Dead reckoning by gyro and wheels, aided by corridor walls, on a log or in simulation.

#include <array>
#include <cstdio>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <wayfare/io/carmen.hpp>
#include <wayfare/sensors/trajectory.hpp>

#include "evaluate.hpp"
#include "on_log.hpp"
#include "outputs.hpp"
#include "support/option_fields.hpp"
#include "support/progress_line.hpp"
#include "support/slam_doubt.hpp"
#include "support/slam_program.hpp"

namespace {

using namespace wayfare;
using namespace wayfare::examples;

struct Options : SlamArguments {
  std::string config;
  DirectionFrom direction = DirectionFrom::automatic;
  int simulated = 0, passes = 4;
  double added_bias_deg_s = 0.0, rate_hz = 0.0;
  WallSearch search = WallSearch::tracking;
  std::vector<double> origin;
  bool no_walls_across = false, rest = false, wall_noise = false;
  bool no_building = false, compare = false, marks = false;
};

/// A recording with options and truth.
struct Job {
  Recording recording;
  CorridorInsOptions options;
  Truth truth;
  std::optional<sim::CorridorDrive> drive;
  double rest_s = 0.0;
  Doubt doubt = {};
};

Result<Job> simulated_job(const Options& o) {
  sim::CorridorDriveParams p;
  p.pattern = o.simulated == 1 ? sim::MotionPattern::straight : sim::MotionPattern::curved;
  auto drive = sim::simulate_corridors(p, Rng(o.seed));
  if (!drive) return drive.error();
  Job job{drive->recording,
          options_for(p, Aiding::end_walls),
          {drive->recording.truth, "the simulation"},
          *std::move(drive),
          p.rest_s};
  return job;
}

Result<Job> log_job(const Options& o) {
  Doubt doubt;
  auto recording = read_robot_log(o.log, o.topics, true, &doubt);
  if (!recording) return recording.error();
  const CorridorInsOptions options = corridor_options_of(*recording);
  Job job{*std::move(recording), options, {}, {}, 0.0, std::move(doubt)};
  auto truth = o.read_truth(job.recording);
  if (!truth) return truth.error();
  job.truth = *std::move(truth);
  return job;
}

std::vector<MotionSample> biased(std::vector<MotionSample> motion, double added_rad_s) {
  for (MotionSample& sample : motion) sample.turn_rate_rad_s += added_rad_s;
  return motion;
}

Result<CorridorRun> run_passes(const Job& job, const Options& o,
                               std::span<const MotionSample> motion) {
  ProgressLine progress("corridors", o.quiet);
  auto run = run_corridor_passes(job.recording, motion, job.options, job.drive ? 1 : o.passes,
                                 [&](double fraction) { progress.update(fraction); });
  if (run) progress.finish();
  return run;
}

struct Runs {
  CorridorRun aided, unaided;
  std::optional<CorridorRun> without_added;  ///< aided, no bias added
  std::size_t reversed = 0;                  ///< samples of motion made backward
};

/// The simulated drive or the log, with the options of --config.
Result<Job> make_job(const Options& o) {
  auto job = o.simulated > 0 ? simulated_job(o) : log_job(o);
  if (!job) return job;
  if (!o.config.empty()) {
    if (auto ok = read_option_fields(o.config, corridor_option_fields(job->options)); !ok)
      return ok.error();
  }
  if (o.no_walls_across) job->options.use_end_walls = false;
  if (o.no_building) job->options.building_sigma_rad = 0.0;
  if (o.marks) job->options.marks_sigma_m = 0.05;
  if (o.rate_hz > 0.0) job->options.least_scan_interval = from_seconds(1.0 / o.rate_hz);
  job->options.search = o.search;
  if (o.rest) job->options.rest_calibrates = true;
  if (o.origin.size() == 3) job->options.latitude_rad = Angle::degrees(o.origin[0]).radians();
  return job;
}

/// All options of --config with their defaults for logs.
std::string corridor_options_text() {
  CorridorInsOptions defaults = corridor_options_for_logs(false);
  return option_fields_text(corridor_option_fields(defaults));
}

Result<Runs> run_all(const Job& job, const Options& o) {
  const double added = Angle::degrees(o.added_bias_deg_s).radians();
  const bool known = job.drive && o.direction == DirectionFrom::automatic;
  const SignedMotion motion =
      signed_motion_of(job.recording, known ? DirectionFrom::wheels : o.direction);
  auto aided = run_passes(job, o, biased(motion.motion, added));
  if (!aided) return aided.error();
  CorridorInsOptions alone = job.options;
  alone.use_walls = false;
  auto unaided = run_corridor_ins(job.recording, motion_of(job.recording, added), alone);
  if (!unaided) return unaided.error();
  Runs runs{*std::move(aided), *std::move(unaided), {}, motion.reversed};
  if (added == 0.0) return runs;
  auto plain = run_passes(job, o, motion.motion);
  if (!plain) return plain.error();
  runs.without_added = *std::move(plain);
  return runs;
}

/// Mean yaw rate of the motion minus that of the true poses, rad/s.
double true_bias(std::span<const MotionSample> motion, const Trajectory& truth) {
  double measured = 0.0, rotated = 0.0, seconds = 0.0;
  for (std::size_t i = 1; i < motion.size(); ++i) {
    const auto a = pose_at(truth, motion[i - 1].time);
    const auto b = pose_at(truth, motion[i].time);
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
  if (!job.drive && job.truth.known() && job.truth.has_heading)
    facts.emplace_back("by the truth", rate(true_bias(motion, job.truth.poses)));
  if (!runs.without_added) return;
  const double plain = runs.without_added->epochs.back().gyro_bias.value;
  const double found = Angle::radians(last.gyro_bias.value - plain).degrees();
  facts.emplace_back("without the added", rate(plain));
  facts.emplace_back("added bias found", eval::fixed(100.0 * found / o.added_bias_deg_s, 2) +
                                             " % of " + eval::fixed(o.added_bias_deg_s, 3) +
                                             " deg/s");
}

void add_direction_facts(const Runs& runs, Facts& facts) {
  if (runs.reversed > 0)
    facts.emplace_back("driven backward", std::to_string(runs.reversed) + " samples, by the scans");
}

void add_report_facts(const CorridorReport& r, Facts& facts) {
  const auto share = [&](std::size_t n) {
    return std::to_string(n) + " (" +
           eval::fixed(100.0 * static_cast<double>(n) / static_cast<double>(r.scans), 1) + " %)";
  };
  facts.emplace_back("scans", std::to_string(r.scans));
  if (r.skipped_scans > 0) facts.emplace_back("skipped", std::to_string(r.skipped_scans));
  facts.emplace_back("with walls", share(r.scans_with_walls));
  facts.emplace_back("walls used", share(r.scans_used));
  facts.emplace_back("by tracking", share(r.tracked));
  facts.emplace_back("end walls", share(r.end_walls_used));
  if (r.marks_used > 0) facts.emplace_back("marks", share(r.marks_used));
  if (r.headings_used > 0) facts.emplace_back("building headings", share(r.headings_used));
  facts.emplace_back("corridors", std::to_string(r.corridors));
  facts.emplace_back("longest outage", eval::fixed(to_seconds(r.longest_outage), 1) + " s");
  facts.emplace_back("refused", std::to_string(r.refused_walls) + " scans, " +
                                    std::to_string(r.refused_sides) + " sides, " +
                                    std::to_string(r.refused_end_walls) + " end walls, " +
                                    std::to_string(r.not_parallel) + " not parallel, " +
                                    std::to_string(r.slipping_samples) + " slipping, " +
                                    std::to_string(r.saturated_samples) + " saturated");
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

std::optional<LocalPlane> plane_of(const Options& o) {
  if (o.origin.size() != 3) return {};
  return LocalPlane{{Angle::degrees(o.origin[0]), Angle::degrees(o.origin[1]), 0.0},
                    Angle::degrees(o.origin[2])};
}

Result<Doubt> run(const Options& o) {
  if (o.log.empty() == (o.simulated == 0)) return bad_use("either a LOG or --simulated is needed");
  std::vector<std::string> files = {"navigation.txt", "trajectory.tum", "unaided.tum", "walls.png",
                                    "report.html"};
  if (o.simulated > 0) files.emplace_back("log.carmen");
  if (o.wall_noise) files.emplace_back("walls.csv");
  if (o.compare) files.emplace_back("detectors.txt");
  if (auto ready = o.prepare(files); !ready) return ready.error();
  auto job = make_job(o);
  if (!job) return job.error();
  const auto runs = run_all(*job, o);
  if (!runs) return runs.error();
  CorridorOutputs outputs{"Corridors: " + (o.log.empty() ? "simulated" : o.log),
                          job->recording,
                          runs->aided,
                          runs->unaided,
                          job->truth,
                          job->drive.has_value(),
                          plane_of(o)};
  add_bias_facts(*job, *runs, o, outputs.facts);
  doubt_share(job->doubt, runs->aided.report.refused_walls, runs->aided.report.scans_with_walls,
              "scans with walls are refused");
  outputs.doubt = job->doubt.why;
  add_report_facts(runs->aided.report, outputs.facts);
  add_direction_facts(*runs, outputs.facts);
  if (o.compare) {
    outputs.detectors = compare_detectors(job->recording, job->options.walls);
    add_detector_facts(outputs.detectors, outputs.facts);
  }
  if (job->drive) {
    outputs.tables.emplace_back("Position RMSE by sections", section_table(*job, *runs));
    for (const CorridorEpoch& e : runs->aided.epochs)
      outputs.bias.push_back(true_bias_at(*job->drive, e.time) +
                             Angle::degrees(o.added_bias_deg_s).radians());
  }
  if (o.wall_noise) {
    outputs.walls = wall_changes(job->recording, runs->aided, job->truth.poses, job->options.walls);
    if (outputs.walls.empty())
      return Error{ErrorCode::not_found, "no two scans in a row have walls", o.log};
    const Facts noise = facts_of(outputs.walls);
    outputs.facts.insert(outputs.facts.end(), noise.begin(), noise.end());
  }
  if (auto done = write_corridor_outputs(o, outputs); !done) return done.error();
  if (job->drive)
    if (auto done = io::write_carmen(o.path("log.carmen"), job->recording, o.write()); !done)
      return done.error();
  if (!o.quiet)
    std::printf("%s%s\nreport: %s\n", to_text(outputs.facts, 18).c_str(),
                to_text(tables_of(outputs)).c_str(), o.path("report.html").c_str());
  return std::move(job->doubt);
}

void add_options(CommandLine& app, Options& o) {
  app.add_file(
      "LOG", o.log,
      std::string(kRobotLogs) + "; from CARMEN text, GYRO and WHEELS lines, else odometry");
  app.add_option("--simulated", o.simulated,
                 "instead of a log: three corridors with straight (1) or curved (2) motion")
      .range(1, 2);
  add_out(app, o);
  o.truth.add_options(app, "--truth,--reference");
  app.add_option("--add-bias", o.added_bias_deg_s, "bias added to the yaw rate, deg/s");
  app.add_option(
         "--origin", o.origin,
         "latitude, longitude and azimuth of the start's x axis, degrees: adds the solution "
         "in latitude and longitude, and removes the Earth's rotation")
      .expected(3);
  app.add_file("--config", o.config, "JSON file of options; see --print-config");
  app.add_number("--passes", o.passes, 1, 20,
                 "passes over a log, each started with the bias of the last");
  app.add_flag("--no-building", o.no_building,
               "logs: do not take headings from all walls of a scan, along and across the first");
  app.add_flag("--marks", o.marks,
               "follow edges of doors and recesses for the way along a corridor");
  app.add_option("--rate", o.rate_hz, "use scans at this rate at most, Hz; default: all")
      .range(0.001, 1e6);
  app.add_choice<WallSearch>(
      "--walls", o.search, {{"tracking", WallSearch::tracking}, {"windows", WallSearch::windows}},
      "find walls by tracking and segments (default), or by curve fitting in moving windows");
  app.add_flag("--compare-detectors", o.compare,
               "also find the walls of each scan by tracking and by curve fitting: times and "
               "directions in the report and detectors.txt");
  app.add_choice<DirectionFrom>(
      "--direction", o.direction,
      {{"auto", DirectionFrom::automatic},
       {"wheels", DirectionFrom::wheels},
       {"scans", DirectionFrom::scans}},
      "forward or backward by the wheels' sign or from the scans; auto: from the scans if "
      "the wheels never count backwards");
  app.add_flag("--no-walls-across", o.no_walls_across, "use side walls only");
  app.add_flag("--rest", o.rest, "estimate the bias from odometry at rest too");
  app.add_flag("--wall-noise", o.wall_noise,
               "also write walls.csv: changes of the walls' distance and angle from scan to scan, "
               "m and deg, their errors with the true poses, and the angle by a second method");
  add_seed(app, o, kSeedHelp);
  add_robot_topics(app, o.topics);
  add_force_and_quiet(app, o);
  add_json(app, o);
  app.add_print("--print-config", corridor_options_text,
                "print all options of --config with their defaults for logs, and exit");
}

}  // namespace

int main(int argc, char** argv) {
  CommandLine app(
      "Dead reckoning by one gyro and wheels, aided by corridor walls in laser scans.\nWrites "
      "navigation.txt, trajectory.tum, unaided.tum, walls.png and report.html.");
  Options options;
  add_options(app, options);
  app.example("robot.log --out corridor", "a recorded log");
  app.example("--simulated 1 --out corridor", "a simulated drive instead");
  if (const auto code = app.parse(argc, argv)) return *code;
  return exit_code("corridor_ins", run(options));
}
