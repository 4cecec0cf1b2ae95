// Attitude and heading from a recorded nine-axis unit: a table and a report out.

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <string>

#include "calibration_file.hpp"
#include "outputs.hpp"
#include "recording.hpp"
#include "run.hpp"
#include "support/command_line.hpp"
#include "support/exit_code.hpp"
#include "support/progress_line.hpp"

namespace {

using namespace wayfare;

struct Arguments {
  std::string file, out, calibration;
  bool force = false;
  bool quiet = false;
  examples::RecordingOptions recording;
  examples::FilterOptions filter;
};

Result<void> run(const Arguments& a) {
  const io::WriteOptions write{a.force ? io::Existing::replace : io::Existing::refuse};
  if (auto free = examples::prepare_ahrs_folder(a.out, write); !free) return free;
  auto file = a.recording.read(a.file);
  if (!file) return file.error();
  if (!a.calibration.empty()) {
    const auto calibration = examples::read_calibration(a.calibration);
    if (!calibration) return calibration.error();
    for (MargSample& s : file->samples) s.magnetic_field_uT = (*calibration)(s.magnetic_field_uT);
  }
  AhrsParameters parameters = a.filter.parameters();
  parameters.use_magnetometer = parameters.use_magnetometer && file->has_magnetometer;

  examples::ProgressLine progress("attitude", a.quiet);
  const auto start = std::chrono::steady_clock::now();
  const examples::AhrsRun done = examples::run_ahrs(file->samples, parameters, a.filter.enu,
                                                    [&](double part) { progress.update(part); });
  progress.finish();
  const auto took = std::chrono::steady_clock::now() - start;
  const auto is_ready = [](const examples::AhrsRow& row) { return row.ready; };
  if (std::none_of(done.rows.begin(), done.rows.end(), is_ready))
    return Error{ErrorCode::degenerate,
                 "gives no attitude: no accelerometer reading near gravity with a gyro reading "
                 "beside it",
                 a.file};
  const examples::AhrsOutputs outputs{
      "Attitude: " + std::filesystem::path(a.file).filename().string(), *file, done,
      std::chrono::duration<double>(took).count()};
  const auto report = examples::write_ahrs_outputs(a.out, outputs, write);
  if (!report) return report.error();
  if (a.quiet) return {};
  std::printf("%s", examples::error_text(outputs).c_str());
  std::printf("%s", examples::status_text(done.report).c_str());
  std::printf("report: %s\n", report->c_str());
  return {};
}

}  // namespace

int main(int argc, char** argv) {
  examples::CommandLine app(
      "Estimate attitude and heading from a recorded unit with gyro, accelerometer and (where it "
      "has one) magnetometer. Writes attitude.csv and report.html.");
  Arguments arguments;
  examples::RecordingOptions::add_path(app, "FILE", arguments.file);
  app.add_option("--out", arguments.out, "folder for the results, made where needed").required();
  app.add_option("--calibration", arguments.calibration,
                 "the magnetometer's, from calibrate_magnetometer")
      .existing_file();
  app.add_flag("--force", arguments.force, "replace files of an earlier run");
  app.add_flag("--quiet", arguments.quiet, "no progress and no tables");
  arguments.recording.describe(app);
  arguments.filter.describe(app);
  if (const auto code = app.parse(argc, argv)) return *code;
  return examples::exit_code("ahrs", run(arguments));
}
