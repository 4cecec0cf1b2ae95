// Inertial navigation with GNSS on a recording: trajectory, errors and a report out.

#include <chrono>
#include <cstdio>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "support/command_line.hpp"
#include "support/exit_code.hpp"
#include "support/nav_config.hpp"
#include "support/nav_outages.hpp"
#include "support/nav_outputs.hpp"
#include "support/nav_recording.hpp"
#include "support/program_files.hpp"
#include "support/progress_line.hpp"
#include "support/ros_topics.hpp"

namespace {

using namespace wayfare;

struct Options {
  examples::NavFiles files;
  std::string config, out, outages;
  double rate_hz = 0.0;
  bool no_constraints = false;
  bool force = false;
  bool quiet = false;
};

Result<examples::NavConfig> config_of(const Options& o) {
  auto config = o.config.empty() ? Result<examples::NavConfig>(examples::NavConfig{})
                                 : examples::read_nav_config(o.config);
  if (config && o.no_constraints) config->filter.non_holonomic_in_outage = false;
  return config;
}

Result<void> run(const Options& o) {
  const io::WriteOptions writing{o.force ? io::Existing::replace : io::Existing::refuse};
  const auto config = config_of(o);
  if (!config) return config.error();
  auto outages = examples::parse_outages(o.outages);
  if (!outages) return outages.error();
  if (auto ready = examples::prepare_files(o.out, examples::nav_output_names(), writing); !ready)
    return ready;
  examples::ProgressLine reading("reading", o.quiet);
  auto recording =
      examples::load_nav_recording(o.files, *config, [&](double f) { reading.update(f); });
  if (!recording) return recording.error();
  reading.finish();
  examples::apply_outages(*outages, recording->recording);

  examples::ProgressLine progress("navigating", o.quiet);
  const auto start = std::chrono::steady_clock::now();
  const auto result =
      run_gnss_ins(recording->recording, config->filter, [&](double f) { progress.update(f); });
  if (!result) return result.error();
  progress.finish();
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start;

  const std::string source = o.files.observations.empty()
                                 ? (o.files.ranges.empty() ? o.files.fixes : o.files.ranges)
                                 : o.files.observations;
  const examples::NavOutputs outputs{
      "Inertial navigation with " + std::filesystem::path(source).filename().string(),
      *recording,
      *config,
      *result,
      *std::move(outages),
      took.count(),
      o.rate_hz};
  const examples::NavFindings findings = examples::find(outputs);
  const auto report = examples::write_nav_outputs(o.out, outputs, findings, writing);
  if (!report) return report.error();
  if (!o.quiet)
    std::printf("%s\nreport: %s\n", examples::summary(outputs, findings).c_str(), report->c_str());
  return {};
}

void add_files(examples::CommandLine& app, examples::NavFiles& files) {
  const auto file = [&](const char* name, auto& path, const char* text) {
    return app.add_option(name, path, text).existing_file();
  };
  file("--imu", files.imu, "inertial samples; given twice: gyro and accelerometer apart")
      .required()
      .expected(1, 2);
  file("--imu-tags", files.imu_tags, "RTKLIB's time tags of the inertial file");
  file("--imu-clock", files.imu_clock, "pairs of the unit's times and GPS times")
      .excludes("--imu-tags");
  file("--obs", files.observations, "raw observations, RINEX 2.1 or 3");
  file("--nav", files.navigation, "broadcast messages, RINEX; may be given again").expected(1, 64);
  file("--ranges", files.ranges, "corrected ranges instead of --obs and --nav").excludes("--obs");
  file("--fixes", files.fixes, "positions and velocities, for loose coupling");
  file("--truth", files.truth, "reference to measure the errors by");
  examples::add_vehicle_topics(app, files.topics);
}

}  // namespace

int main(int argc, char** argv) {
  examples::CommandLine app(
      "Navigate by an inertial unit and a GNSS receiver, tightly coupled by ranges or loosely by "
      "fixes.\nThe unit and the fixes may be those of one ROS recording (.mcap, .bag), which is "
      "then given for both. Files of columns name them in a line of their own or by --config. "
      "Writes "
      "trajectory.txt, trajectory.tum, states.txt and report.html.");
  Options o;
  add_files(app, o.files);
  app.add_option("--config", o.config, "JSON description of the recording; see --print-config")
      .existing_file();
  app.add_option("--outage", o.outages,
                 "take satellites away: START:LENGTH[:SATELLITES LEFT],... in seconds since the "
                 "first inertial sample");
  app.add_option("--out", o.out, "folder for the results, made where needed").required();
  app.add_option("--rate", o.rate_hz, "lines a second of trajectory.txt; 0: the unit's")
      .range(0.0, 1e4)
      .show_default();
  app.add_flag(
      "--no-constraints", o.no_constraints,
      "the vehicle may slide sideways and vertically in outages; standstill is still seen");
  app.add_flag("--force", o.force, "replace files of an earlier run");
  app.add_flag("--quiet", o.quiet, "no progress and no tables");
  app.add_print(
      "--print-config", [] { return examples::default_nav_config(); },
      "print every option of --config with its default, and end");
  if (const auto code = app.parse(argc, argv)) return *code;
  return examples::exit_code("gnss_ins", run(o));
}
