// Attitude and heading from a recorded nine-axis unit.

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <string>

#include "calibration_file.hpp"
#include "outputs.hpp"
#include "recording.hpp"
#include "support/progress_line.hpp"

namespace {

using namespace wayfare;
using namespace wayfare::examples;

struct Arguments : OutputArguments {
  std::string file, calibration;
  RecordingOptions recording;
  FilterOptions filter;
};

Result<void> run(const Arguments& a) {
  if (auto ready = a.prepare(ahrs_output_names()); !ready) return ready;
  auto file = a.recording.read(a.file);
  if (!file) return file.error();
  if (!a.calibration.empty()) {
    const auto calibration = read_calibration(a.calibration);
    if (!calibration) return calibration.error();
    for (MargSample& s : file->samples) s.magnetic_field_uT = (*calibration)(s.magnetic_field_uT);
  }
  AhrsParameters parameters = a.filter.parameters();
  parameters.use_magnetometer = parameters.use_magnetometer && file->has_magnetometer;

  ProgressLine progress("attitude", a.quiet);
  const AhrsRun run = run_ahrs(file->samples, parameters, a.filter.enu, std::ref(progress));
  const double took_s = progress.finish();
  const auto is_ready = [](const AhrsRow& row) { return row.ready; };
  if (std::none_of(run.rows.begin(), run.rows.end(), is_ready))
    return Error{ErrorCode::degenerate,
                 "gives no attitude: no accelerometer reading near gravity with a gyro reading at "
                 "the same time",
                 a.file};
  const AhrsOutputs outputs{"Attitude: " + std::filesystem::path(a.file).filename().string(), *file,
                            run, took_s};
  if (auto done = write_ahrs_outputs(a, outputs); !done || a.quiet) return done;
  std::printf("%s%sreport: %s\n", error_text(outputs).c_str(), status_text(run.report).c_str(),
              a.path("report.html").c_str());
  return {};
}

}  // namespace

int main(int argc, char** argv) {
  CommandLine app(
      "Estimate attitude and heading from a recorded unit with gyro, accelerometer and, "
      "optionally, magnetometer. Writes attitude.csv and report.html.");
  Arguments arguments;
  RecordingOptions::add_path(app, "FILE", arguments.file);
  add_out(app, arguments);
  app.add_file("--calibration", arguments.calibration,
               "of the magnetometer, from calibrate_magnetometer");
  add_force_and_quiet(app, arguments);
  arguments.recording.add_options(app);
  arguments.filter.add_options(app);
  if (const auto code = app.parse(argc, argv)) return *code;
  return exit_code("ahrs", run(arguments));
}
