// Hard and soft iron of a magnetometer from a recording of it being turned about.

#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

#include <wayfare/inertial/magnetometer_calibration.hpp>

#include "calibration_file.hpp"
#include "recording.hpp"
#include "support/command_line.hpp"
#include "support/exit_code.hpp"

namespace {

using namespace wayfare;

struct Arguments {
  std::string file, out;
  bool force = false;
  examples::RecordingOptions recording;
  MagnetometerCalibrationOptions options;
};

void print(const MagnetometerCalibration& c) {
  const auto row = [](const char* name, const Eigen::Vector3d& v, const Eigen::Vector3d& sigma) {
    std::printf("%-14s", name);
    for (int i = 0; i < 3; ++i) std::printf("  %9.4f +- %.4f", v[i], sigma[i]);
    std::printf("\n");
  };
  row("offset [uT]", c.offset_uT, c.offset_sigma_uT);
  row("correction", c.correction.row(0), c.correction_sigma.row(0));
  row("", c.correction.row(1), c.correction_sigma.row(1));
  row("", c.correction.row(2), c.correction_sigma.row(2));
  std::printf("%-14s  %9.4f uT\n", "field", c.field_uT);
  std::printf("%-14s  %9.4f uT, %.4f before\n", "residual", c.residual_uT, c.raw_residual_uT);
  std::printf("%-14s  %9zu\n", "readings used", c.used);
}

Result<void> run(const Arguments& a) {
  if (!a.out.empty() && !a.force && std::filesystem::exists(a.out))
    return Error{ErrorCode::io, "exists already; --force overwrites it", a.out};
  const auto file = a.recording.read(a.file);
  if (!file) return file.error();
  if (!file->has_magnetometer)
    return Error{ErrorCode::not_found, "has no magnetometer columns", a.file};
  std::vector<Eigen::Vector3d> readings;
  for (const MargSample& s : file->samples) readings.push_back(s.magnetic_field_uT);
  const auto calibration = calibrate_magnetometer(readings, a.options);
  if (!calibration) return Error{calibration.error().code, calibration.error().message, a.file};
  print(*calibration);
  if (a.out.empty()) return {};
  return examples::write_calibration(a.out, *calibration,
                                     {a.force ? io::Existing::replace : io::Existing::refuse});
}

}  // namespace

int main(int argc, char** argv) {
  examples::CommandLine app(
      "Find offset and correction of a magnetometer from a recording in which it is turned through "
      "all orientations: calibrated = correction (raw - offset). Standard deviations stand behind "
      "the figures.");
  Arguments arguments;
  examples::RecordingOptions::add_path(app, "FILE", arguments.file);
  app.add_option("--out", arguments.out, "JSON file for the calibration; `ahrs` reads it");
  app.add_flag("--force", arguments.force, "overwrite the output where it exists");
  app.add_option("--field", arguments.options.field_uT,
                 "strength of the Earth's field here, uT (default: keep the mean strength)")
      .positive();
  arguments.recording.describe(app);
  if (const auto code = app.parse(argc, argv)) return *code;
  return examples::exit_code("calibrate_magnetometer", run(arguments));
}
