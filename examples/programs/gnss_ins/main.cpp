// Inertial navigation with GNSS on a recording.

#include <cstdio>
#include <filesystem>
#include <string>

#include <wayfare/nav/outage.hpp>

#include "support/command_line.hpp"
#include "support/nav_outputs.hpp"
#include "support/progress_line.hpp"
#include "support/ros_topics.hpp"

namespace {

using namespace wayfare;
using namespace wayfare::examples;

struct Options : OutputArguments {
  NavFiles files;
  std::string config, outages;
  double rate_hz = 0.0;
  bool no_constraints = false;
};

Result<Doubt> run(const Options& o) {
  auto config = read_nav_config(o.config);
  if (!config) return config.error();
  if (o.no_constraints) config->filter.non_holonomic_in_outage = false;
  auto outages = parse_outages(o.outages);
  if (!outages) return outages.error();
  if (auto ready = o.prepare({"trajectory.txt", "trajectory.tum", "states.txt", "report.html"});
      !ready)
    return ready.error();
  ProgressLine reading("reading", o.quiet);
  auto recording = load_nav_recording(o.files, *config, std::ref(reading));
  if (!recording) return recording.error();
  reading.finish();
  for (const NavOutage& outage : *outages) {
    const LogTime begin = recording->recording.imu.front().time + from_seconds(outage.start_s);
    apply_outage({begin, begin + from_seconds(outage.length_s), outage.satellites_left},
                 recording->recording);
  }

  ProgressLine progress("navigating", o.quiet);
  const auto result = run_gnss_ins(recording->recording, config->filter, std::ref(progress));
  if (!result) return result.error();
  const double took_s = progress.finish();

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
  const NavFindings findings = evaluate(outputs);
  if (auto done = write_nav_outputs(o, outputs, findings); !done) return done.error();
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
  app.add_file("--obs", files.observations, "raw observations, RINEX 2.1 or 3");
  app.add_file("--nav", files.navigation, "broadcast messages, RINEX; several files allowed")
      .expected(1, 64);
  app.add_file("--ranges", files.ranges, "corrected ranges instead of --obs and --nav")
      .excludes("--obs");
  app.add_file("--fixes", files.fixes, "positions and velocities, for loose coupling");
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
  app.add_option("--outage", o.outages,
                 "remove satellites: START:LENGTH[:SATELLITES LEFT],... in seconds since the first "
                 "inertial sample");
  add_out(app, o);
  app.add_number("--rate", o.rate_hz, 0.0, 1e4,
                 "lines per second of trajectory.txt; 0: rate of the unit");
  app.add_flag("--no-constraints", o.no_constraints,
               "allow sideways and vertical motion in outages; standstill is still detected");
  add_force_and_quiet(app, o);
  add_json(app, o);
  app.add_print(
      "--print-config", [] { return default_nav_config(); },
      "print all options of --config with their defaults, and exit");
  app.example("--imu imu.txt --ranges ranges.txt --truth truth.txt --out run",
              "the files of simulate_drive");
  app.example("--imu imu.txt --obs rover.obs --nav brdc.nav --config drive.json --out run",
              "a recorded drive");
  if (const auto code = app.parse(argc, argv)) return *code;
  return exit_code("gnss_ins", run(o));
}
