// Inertial navigation with GNSS on a recording.

#include <cstdio>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include <wayfare/nav/outage.hpp>

#include "support/command_line.hpp"
#include "support/dry_run.hpp"
#include "support/nav_check.hpp"
#include "support/nav_outputs.hpp"
#include "support/progress_line.hpp"
#include "support/ros_topics.hpp"
#include "support/track_files.hpp"

namespace {

using namespace wayfare;
using namespace wayfare::examples;

struct Options : OutputArguments {
  NavFiles files;
  TrackFormats formats;
  std::string config, outages;
  double rate_hz = 0.0;
  bool no_constraints = false, phases = false, smooth = false, dry_run = false, check = false;
  std::vector<std::string> columns, filter;
};

/// An error of the filter with what the data tell of its cause.
Error explained(const Error& error, const std::vector<DriveFinding>& findings) {
  Error result = error;
  for (const DriveFinding& f : findings) result.message += "\n  " + line_of(f);
  return result;
}

Result<Doubt> check(const Options& o, const NavConfig& config) {
  if (auto ready = o.prepare({"found.json", "report.html"}); !ready) return ready.error();
  ProgressLine reading("reading", o.quiet);
  const auto recording = load_nav_recording(o.files, config, std::ref(reading), true);
  if (!recording) return recording.error();
  reading.finish();
  return check_nav_recording(o, o.config, config, *recording);
}

Result<Doubt> run(const Options& o) {
  auto config = read_nav_config(o.config);
  if (!config) return config.error();
  if (auto chosen = choose_columns(o.columns, *config); !chosen) return chosen.error();
  if (auto set = set_filter_options(o.filter, *config); !set) return set.error();
  if (o.dry_run) {
    const auto text = dry_run(o.files, *config);
    if (!text) return text.error();
    std::fputs(text->c_str(), stdout);
    return Doubt{};
  }
  if (o.out.empty()) return bad_use("--out is required");
  if (o.files.wheels.empty()) config->filter.odometer.reset();
  if (!o.files.wheels.empty() && !config->filter.odometer) config->filter.odometer.emplace();
  if (o.phases && !config->filter.carrier_phase) config->filter.carrier_phase.emplace();
  if (o.check) return check(o, *config);
  if (o.no_constraints) config->filter.non_holonomic_in_outage = false;
  auto outages = parse_outages(o.outages);
  if (!outages) return outages.error();
  if (auto ready = o.prepare(
          o.formats.with_files({"trajectory.txt", "trajectory.tum", "states.txt", "report.html"}));
      !ready)
    return ready.error();
  ProgressLine reading("reading", o.quiet);
  auto recording = load_nav_recording(o.files, *config, std::ref(reading));
  if (!recording) return recording.error();
  reading.finish();
  const std::vector<ImuSample>& imu = recording->recording.imu;
  if (auto ok = check_outages(*outages, to_seconds(imu.back().time - imu.front().time)); !ok)
    return ok.error();
  std::vector<DriveFinding> found = check_drive(recording->recording, config->filter).findings;
  for (const NavOutage& outage : *outages) {
    const LogTime begin = imu.front().time + from_seconds(outage.start_s);
    apply_outage({begin, begin + from_seconds(outage.length_s), outage.satellites_left},
                 recording->recording);
  }

  ProgressLine progress("navigating", o.quiet);
  const auto result =
      o.smooth ? smooth_gnss_ins(recording->recording, config->filter, std::ref(progress))
               : run_gnss_ins(recording->recording, config->filter, std::ref(progress));
  if (!result) return explained(result.error(), found);
  const double took_s = progress.finish();
  for (DriveFinding& f : check_run(recording->recording, *result)) found.push_back(std::move(f));
  for (const DriveFinding& f : found) recording->remarks.push_back(line_of(f));

  const std::string source = o.files.observations.empty()
                                 ? (o.files.ranges.empty() ? o.files.fixes : o.files.ranges)
                                 : o.files.observations;
  const NavOutputs outputs{
      "Inertial navigation with " + std::filesystem::path(source).filename().string(),
      *recording,
      *config,
      *result,
      *std::move(outages),
      took_s,
      o.rate_hz};
  NavFindings findings = evaluate(outputs);
  if (Doubt named = doubt_of(found); !named.why.empty()) findings.doubt = std::move(named);
  if (auto done = first_error({write_nav_outputs(o, outputs, findings),
                               write_track_files(o, o.formats, track_of(outputs))});
      !done)
    return done.error();
  if (!o.quiet)
    std::printf("%s\nreport: %s\n", summary(outputs, findings).c_str(),
                o.path("report.html").c_str());
  return findings.doubt;
}

void add_files(CommandLine& app, NavFiles& files) {
  app.add_file("--imu", files.imu,
               "inertial samples; two files if gyro and accelerometer are separate")
      .required()
      .expected(1, 2);
  app.add_file("--imu-tags", files.imu_tags, "RTKLIB's time tags of the inertial file");
  app.add_file("--imu-clock", files.imu_clock, "pairs of the unit's times and GPS times")
      .excludes("--imu-tags");
  app.add_file("--obs", files.observations, "raw observations, RINEX 2.1 or 3, or UBX (RXM-RAWX)");
  app.add_file(
         "--nav", files.navigation,
         "broadcast messages, RINEX; several files allowed; not needed where UBX has those of GPS")
      .expected(1, 64);
  app.add_file("--ranges", files.ranges, "corrected ranges instead of --obs and --nav")
      .excludes("--obs");
  app.add_file(
      "--fixes", files.fixes,
      "positions and velocities, for loose coupling: columns, RTKLIB's .pos, UBX (NAV-PVT), "
      "NMEA, GPX");
  app.add_file(
      "--wheels", files.wheels,
      "with the speeds of wheels, of an axle that does not steer: columns of time and speed_mps");
  app.add_file("--truth", files.truth, "reference to compare with");
  add_vehicle_topics(app, files.topics);
}

}  // namespace

int main(int argc, char** argv) {
  CommandLine app(
      "Navigate by an inertial unit and a GNSS receiver, tightly coupled by ranges or loosely by "
      "fixes.\nIf both are in one ROS recording (.mcap, .bag), give it for both. Text files name "
      "their columns in a header line or in --config. Writes trajectory.txt, trajectory.tum, "
      "states.txt and report.html.");
  Options o;
  add_files(app, o.files);
  app.add_file("--config", o.config, "JSON description of the recording; see --print-config");
  app.add_option(
         "--column", o.columns,
         "FILE:NAME=COLUMN, a column of a foreign file by heading or number: "
         "imu:gx_degps=\"Gyro X\"; FILE is imu, imu2, imu_clock, ranges, fixes, wheels or truth")
      .take_all();
  app.add_option("--filter", o.filter,
                 "NAME=VALUE, an option in \"filter\" of --print-config, such as "
                 "correlated_share=0.8")
      .take_all();
  app.add_flag("--dry-run", o.dry_run,
               "only print the columns and first rows of the files as they are understood");
  app.add_option("--outage", o.outages,
                 "remove satellites: START:LENGTH[:SATELLITES LEFT],... in seconds since the first "
                 "inertial sample");
  app.add_option("--out", o.out, kResultsFolder).shown_as("DIR");
  app.add_number("--rate", o.rate_hz, 0.0, 1e4,
                 "lines per second of trajectory.txt; 0: rate of the unit");
  app.add_flag("--no-constraints", o.no_constraints,
               "allow sideways and vertical motion in outages; standstill is still detected");
  app.add_flag("--phases", o.phases,
               "with carrier phases, of --obs or --ranges: their change between epochs");
  app.add_flag("--smooth", o.smooth,
               "estimate each instant by all measurements, also those after it");
  o.formats.add_option(app);
  app.add_flag("--check", o.check,
               "only find units, signs, mounting, times and lever arm of the unit from the data, "
               "and write found.json, a description with them");
  add_force_and_quiet(app, o);
  add_json(app, o);
  app.add_print(
      "--print-config", [] { return default_nav_config(); },
      "print all options of --config with their defaults, and exit");
  app.example("--imu imu.txt --ranges ranges.txt --truth truth.txt --out run",
              "the files of simulate_drive");
  app.example("--imu car.csv --column imu:t_ms=Time --column imu:ax_g=5 --dry-run",
              "how the columns of a foreign file are understood");
  app.example("--imu imu.txt --obs rover.obs --nav brdc.nav --config drive.json --out run",
              "a recorded drive");
  app.example("--imu imu.txt --ranges ranges.txt --wheels wheels.txt --phases --out run",
              "with the speed of the wheels and carrier phases");
  app.example("--check --imu imu.txt --ranges ranges.txt --out checked",
              "what is wrong with a drive, and its description in checked/found.json");
  if (const auto code = app.parse(argc, argv)) return *code;
  return exit_code("gnss_ins", run(o));
}
